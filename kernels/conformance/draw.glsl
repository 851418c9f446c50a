// What the raster cases draw with.
layout(push_constant) uniform DrawnPush {
    uint mode;
    uint first; // triangle
    uint columns; // of the target
    uint per_point; // quads
} push;

// Of `ids.frag`.
const uint MODE_IDS = 0u;
const uint MODE_INTERPOLATED = 1u;
const uint MODE_DERIVATIVE = 2u;
const uint MODE_BITS = 3u;
