// Boxes round blocks of beams, then round groups of blocks: one invocation a box.
#include "shared/index.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/tally.glsl"

layout(set = 3, binding = 2, std430) buffer BeamBoxes { BeamBox beam_boxes[]; };
layout(push_constant) uniform BoxesPush {
    uint capacity; // beams
    uint groups;   // 1: boxes of groups, whose blocks are there already
    uint blocks;   // boxes of blocks, after which those of groups are kept
    uint boxes;    // to make
} push;

void add(inout BeamBox box, BeamBox part) {
    box.start_low = min(box.start_low, part.start_low);
    box.start_high = max(box.start_high, part.start_high);
    box.end_low = min(box.end_low, part.end_low);
    box.end_high = max(box.end_high, part.end_high);
    box.beams += part.beams;
    box.media |= part.media;
}

void main() {
    uint index = linear_index();
    if (index >= push.boxes) return;
    BeamBox box = BeamBox(vec3(3e38), 0u, vec3(-3e38), 0u, vec3(3e38), 0.0, vec3(-3e38), 0.0);
    if (push.groups != 0u) {
        uint last = min((index + 1u) * GROUP_BLOCKS, push.blocks);
        for (uint block = index * GROUP_BLOCKS; block < last; block++) {
            BeamBox part = beam_boxes[block];
            if (part.beams > 0u) add(box, part);
        }
        beam_boxes[push.blocks + index] = box;
        return;
    }
    uint last = min((index + 1u) * BLOCK_BEAMS, beam_count(push.capacity));
    for (uint i = index * BLOCK_BEAMS; i < last; i++) {
        Beam beam = beams[i];
        if ((beam.flags & BEAM_EMPTY) != 0u) continue;
        if (!beam_is_finite(beam)) {
            tally(TALLY_NON_FINITE, 1u);
            continue;
        }
        vec2 range = beam_range(beam);
        BeamBox own = box;
        own.beams = 1u;
        own.media = medium_bit(beam.medium);
        box_of_range(beam, range.xx, own.start_low, own.start_high);
        box_of_range(beam, range.yy, own.end_low, own.end_high);
        add(box, own);
    }
    beam_boxes[index] = box;
}
