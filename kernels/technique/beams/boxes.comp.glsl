// Boxes round blocks of beams, then round groups of blocks: one invocation a box.
#include "shared/index.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/tally.glsl"
#include "technique/beams/shaft.glsl"

layout(set = 3, binding = 2, std430) buffer BeamBoxes { BeamBox beam_boxes[]; };
layout(push_constant) uniform BoxesPush {
    uint capacity; // beams
    uint groups;   // 1: boxes of groups, whose blocks are there already
    uint blocks;   // boxes of blocks, after which those of groups are kept
    uint boxes;    // to make
} push;

void add(inout BeamBox box, vec3 low, vec3 high, uint beams, uint media) {
    box.low = min(box.low, low);
    box.high = max(box.high, high);
    box.beams += beams;
    box.media |= media;
}

bool is_kept(Beam beam) {
    return (beam.flags & BEAM_EMPTY) == 0u && beam_is_finite(beam);
}

void widen(inout vec2 bounds, float value) {
    bounds = vec2(min(bounds.x, value), max(bounds.y, value));
}

// A shaft round the edges of beams from `first` to before `last`.
Shaft block_shaft(uint first, uint last, vec3 ways) {
    Shaft shaft;
    float size = length(ways);
    shaft.axis = size > 0.0 ? ways / size : vec3(0.0, 1.0, 0.0);
    basis(shaft.axis, shaft.across[0], shaft.across[1]);
    shaft.ends = vec2(3e38, -3e38);
    bool parallel = false;
    for (uint i = first; i < last; i++) {
        Beam beam = beams[i];
        if (!is_kept(beam)) continue;
        vec2 range = beam_range(beam);
        for (uint edge = 0u; edge < 3u; edge++) {
            BeamCorner corner = beam.corners[edge];
            widen(shaft.ends, dot(corner.origin + range.x * corner.way, shaft.axis));
            widen(shaft.ends, dot(corner.origin + range.y * corner.way, shaft.axis));
            parallel = parallel || dot(corner.way, shaft.axis) < LEAST_COSINE * length(corner.way);
        }
    }
    vec2 bounds[4];
    for (uint i = 0u; i < 4u; i++) bounds[i] = vec2(3e38, -3e38);
    for (uint i = first; i < last; i++) {
        Beam beam = beams[i];
        if (!is_kept(beam)) continue;
        vec2 range = beam_range(beam);
        for (uint edge = 0u; edge < 3u; edge++) {
            BeamCorner corner = beam.corners[edge];
            vec3 from = corner.origin + range.x * corner.way;
            vec3 to = corner.origin + range.y * corner.way;
            float along = dot(corner.way, shaft.axis);
            for (uint end = 0u; end < 2u; end++) {
                vec3 at = from + (shaft.ends[end] - dot(from, shaft.axis)) / along * corner.way;
                for (uint axis = 0u; axis < 2u; axis++) {
                    if (parallel) {
                        widen(bounds[2u * end + axis], dot(from, shaft.across[axis]));
                        widen(bounds[2u * end + axis], dot(to, shaft.across[axis]));
                    } else {
                        widen(bounds[2u * end + axis], dot(at, shaft.across[axis]));
                    }
                }
            }
        }
    }
    shaft.at_near = vec4(bounds[0], bounds[1]);
    shaft.at_far = vec4(bounds[2], bounds[3]);
    add_slack(shaft);
    return shaft;
}

void main() {
    uint index = linear_index();
    if (index >= push.boxes) return;
    BeamBox box;
    box.low = vec3(3e38);
    box.high = vec3(-3e38);
    box.beams = 0u;
    box.media = 0u;
    if (push.groups != 0u) {
        uint last = min((index + 1u) * GROUP_BLOCKS, push.blocks);
        for (uint block = index * GROUP_BLOCKS; block < last; block++) {
            BeamBox part = beam_boxes[block];
            if (part.beams > 0u) add(box, part.low, part.high, part.beams, part.media);
        }
        beam_boxes[push.blocks + index] = box;
        return;
    }
    uint first = index * BLOCK_BEAMS;
    uint last = min(first + BLOCK_BEAMS, beam_count(push.capacity));
    vec3 ways = vec3(0.0);
    for (uint i = first; i < last; i++) {
        Beam beam = beams[i];
        if ((beam.flags & BEAM_EMPTY) != 0u) continue;
        if (!is_kept(beam)) {
            tally(TALLY_NON_FINITE, 1u);
            continue;
        }
        vec3 low, high;
        box_of_range(beam, beam_range(beam), low, high);
        add(box, low, high, 1u, medium_bit(beam.medium));
        ways += beam.normal;
    }
    if (box.beams > 0u) {
        Shaft shaft = block_shaft(first, last, ways);
        box.axis = shaft.axis;
        box.near = shaft.ends.x;
        box.far = shaft.ends.y;
        box.at_near = shaft.at_near;
        box.at_far = shaft.at_far;
    }
    beam_boxes[index] = box;
}
