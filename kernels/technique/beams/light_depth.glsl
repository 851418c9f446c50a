// Of the light's way in a beam, what it comes through.
#include "technique/beams/section.glsl"
#include "technique/beams/beam_depths.glsl"

layout(set = 3, binding = 8, std430) readonly buffer AllBeamDepths { BeamDepths beam_depths[]; };

// Up to place `place` of the edge; 0 is the first.
float part_at(uint edge, uint place) {
    if (place == 0u) return 0.0;
    vec2 pair = unpackHalf2x16(beam_depths[edge].parts[(place - 1u) / 2u]);
    return (place & 1u) != 0u ? pair.x : pair.y;
}

// m of density 1 between where the light left its surface and the section's point: the edges', by its weights.
float light_depth(uint index, Beam beam, Section section) {
    float depth = 0.0;
    for (uint i = 0u; i < 3u; i++) {
        uint edge = 3u * index + i;
        BeamCorner corner = beam.corners[i];
        float along = (section.y - corner.start) * length(corner.way) - beam_depths[edge].first;
        float at = clamp(along / max(beam_depths[edge].step, 1e-20), 0.0, float(BEAM_PLACES));
        uint place = min(uint(at), BEAM_PLACES - 1u);
        float part = mix(part_at(edge, place), part_at(edge, place + 1u), at - float(place));
        depth += section.weights[i] * beam_depths[edge].total * part;
    }
    return max(depth, 0.0);
}
