// Stretches of camera paths that lie in media which scatter. frame/walk writes them, up to SEGMENTS a slot of visible
// points; stretch k of a slot is element k * slots + slot. What lies before the interface that is split belongs to the
// first layer alone. Only where view.segments is not 0.

const uint SEGMENTS = 4u;
const uint NO_MEDIUM = 0xffffu;

struct ViewSegment {
    vec3 origin;              // m, world space
    uint throughput_rg;       // radiance at the camera over radiance at `origin`, two half floats
    vec3 end;
    uint throughput_b_medium; // a half float in the low half, the medium in the high half; NO_MEDIUM: empty
};

// Stages that cannot write to buffers say readonly.
#ifndef SEGMENTS_ACCESS
#define SEGMENTS_ACCESS
#endif
layout(set = 2, binding = 17, std430) SEGMENTS_ACCESS buffer ViewSegments { ViewSegment view_segments[]; };

// Half floats are normal from 6e-5 to 65504; throughputs, which n^2 takes to 100 at most, from 1e-7 on.
const float THROUGHPUT_SCALE = 512.0;

struct Stretch {
    vec3 origin;
    vec3 direction;  // unit, away from the camera
    float extent;    // m; glslang takes `length` for the method
    uint medium;     // NO_MEDIUM: empty
    vec3 throughput; // radiance at the camera over radiance at `origin`
};

Stretch stretch(uint k, uint slot, uint slots) {
    ViewSegment s = view_segments[k * slots + slot];
    vec3 way = s.end - s.origin;
    float size = length(way);
    uint medium = size > 0.0 ? s.throughput_b_medium >> 16 : NO_MEDIUM;
    vec3 throughput = vec3(unpackHalf2x16(s.throughput_rg), unpackHalf2x16(s.throughput_b_medium).x) / THROUGHPUT_SCALE;
    return Stretch(s.origin, way / max(size, 1e-37), size, medium, throughput);
}

ViewSegment view_segment(vec3 origin, vec3 end, vec3 throughput, uint medium) {
    vec3 scaled = min(throughput * THROUGHPUT_SCALE, 65504.0);
    return ViewSegment(origin, packHalf2x16(scaled.xy), end, (packHalf2x16(vec2(scaled.z, 0.0)) & 0xffffu) | medium << 16);
}

ViewSegment empty_segment() {
    return ViewSegment(vec3(0.0), 0u, vec3(0.0), NO_MEDIUM << 16);
}
