// The beams that are accumulated, and the boxes round groups of them. renderer/technique/beams/accumulate.
#include "technique/beams/beam.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Beams { Beam beams[]; };
layout(set = 3, binding = 1, std430) readonly buffer BeamHeaders { BeamHeader beam_header; };

// Beams that follow each other are near each other: a block's box says for 32 of them, and a group's for 32 blocks, that
// none is here.
const uint BLOCK_BEAMS = 32u;
const uint GROUP_BLOCKS = 32u;

// A box where the beams begin and one where they end: they keep to what is between the two, which is far less than a box
// round both where light comes at a slant.
struct BeamBox {
    vec3 start_low; // m
    uint beams;     // that are not empty
    vec3 start_high;
    uint media;     // a bit for each medium below 31 that a beam of it is in; bit 31 for all others
    vec3 end_low;
    float padding0;
    vec3 end_high;
    float padding1;
};

// Whether any straight line from the first box to the second can meet the box from `low` to `high`.
bool beams_meet_box(BeamBox beams_box, vec3 low, vec3 high) {
    vec3 all_low = min(beams_box.start_low, beams_box.end_low);
    vec3 all_high = max(beams_box.start_high, beams_box.end_high);
    if (any(greaterThan(all_low, high)) || any(lessThan(all_high, low))) return false;
    // Along an axis that parts the two boxes, the other box is met between these parts of the way.
    vec3 down = beams_box.start_low - beams_box.end_high;
    vec3 up = beams_box.end_low - beams_box.start_high;
    vec3 gap = max(down, up);
    uint axis = gap.x >= gap.y && gap.x >= gap.z ? 0u : gap.y >= gap.z ? 1u : 2u;
    if (gap[axis] <= 0.0) return true;
    float from, to;
    if (down[axis] >= up[axis]) {
        from = (beams_box.start_low[axis] - high[axis]) / (beams_box.start_low[axis] - beams_box.end_low[axis]);
        to = (beams_box.start_high[axis] - low[axis]) / (beams_box.start_high[axis] - beams_box.end_high[axis]);
    } else {
        from = (low[axis] - beams_box.start_high[axis]) / (beams_box.end_high[axis] - beams_box.start_high[axis]);
        to = (high[axis] - beams_box.start_low[axis]) / (beams_box.end_low[axis] - beams_box.start_low[axis]);
    }
    from = clamp(from - 1e-4, 0.0, 1.0);
    to = clamp(to + 1e-4, 0.0, 1.0);
    vec3 part_low = min(mix(beams_box.start_low, beams_box.end_low, from), mix(beams_box.start_low, beams_box.end_low, to));
    vec3 part_high =
        max(mix(beams_box.start_high, beams_box.end_high, from), mix(beams_box.start_high, beams_box.end_high, to));
    return all(lessThanEqual(part_low, high)) && all(greaterThanEqual(part_high, low));
}

uint medium_bit(uint medium) {
    return 1u << min(medium, 31u);
}

uint beam_count(uint capacity) {
    return min(beam_header.count, capacity);
}
