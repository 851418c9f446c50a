// Where the camera's picture shows a place, for rasterisers.
#include "shared/view.glsl"

// Metres. With a reversed infinite depth range its size costs no precision.
const float NEAR = 1e-4;

// Clip space of the band, shifted so that pixel centres are where the sample with this jitter looks.
vec4 project(vec3 position, vec2 jitter) {
    vec3 way = position - view.position;
    float w = dot(way, view.forward);
    vec2 clip = vec2(dot(way, view.right) / dot(view.right, view.right), -dot(way, view.up) / dot(view.up, view.up));
    // From the whole picture to this band, and from the pixel's middle to the sample.
    vec2 size = vec2(view.width, view.height);
    vec2 band = vec2(view.width, view.rows);
    vec2 origin = jitter - 0.5 + vec2(0.0, view.first_row);
    return vec4(((clip + w) * size * 0.5 - origin * w) * 2.0 / band - w, NEAR, w);
}
