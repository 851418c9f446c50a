// Refinement goes by stages, coarse to fine: stage 2k makes middles of cells of level k, stage 2k + 1 middles of their
// edges.
#include "technique/beams/lattice.glsl"

layout(push_constant) uniform StagePush {
    vec2 jitter; // of the lattice, in coarse cells
    uint stage;
    uint padding0;
} push;

// Candidates of a stage in one view.
uint stage_size() {
    uint cells = settings.grid << (push.stage / 2u);
    return (push.stage & 1u) == 0u ? cells * cells : 2u * cells * (cells + 1u);
}

Middle candidate(uint index) {
    uint level = push.stage / 2u;
    uint cells = settings.grid << level;
    int side = int(1u << (settings.levels - level));
    uint size = stage_size();
    uint rest = index % size;
    Middle m = Middle(index / size, ivec2(0), side / 2, (push.stage & 1u) == 0u, false);
    if (m.of_cell) {
        m.at = ivec2(rest % cells, rest / cells) * side + m.half_side;
        return m;
    }
    uint along = cells * (cells + 1u);
    m.upright = rest >= along;
    if (m.upright) {
        rest -= along;
        m.at = ivec2(rest % (cells + 1u), rest / (cells + 1u)) * side + ivec2(0, m.half_side);
    } else {
        m.at = ivec2(rest % cells, rest / cells) * side + ivec2(m.half_side, 0);
    }
    return m;
}
