// The beams that are accumulated, and the boxes round groups of them. renderer/technique/beams/accumulate.
#include "technique/beams/beam.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Beams { Beam beams[]; };
layout(set = 3, binding = 1, std430) readonly buffer BeamHeaders { BeamHeader beam_header; };

// Beams that follow each other are near each other: a block's box says for 32 of them, and a group's for 32 blocks, that
// none is here.
const uint BLOCK_BEAMS = 32u;
const uint GROUP_BLOCKS = 32u;

struct BeamBox {
    vec3 low;   // m
    uint beams; // that are not empty
    vec3 high;
    uint media; // a bit for each medium below 31 that a beam of it is in; bit 31 for all others
    // Of a block, closer round its beams: their mean direction, and bounds across it (shaft.glsl).
    vec3 axis;
    float near;
    vec4 at_near;
    vec4 at_far;
    float far;
    float padding0;
    float padding1;
    float padding2;
};

uint medium_bit(uint medium) {
    return 1u << min(medium, 31u);
}

uint beam_count(uint capacity) {
    return min(beam_header.count, capacity);
}
