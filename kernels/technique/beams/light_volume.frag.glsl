// A beam's light at the stretch of a camera path that begins at the camera, for each pixel of its hull.
#define SEGMENTS_ACCESS readonly
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "technique/beams/volume_light.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/hull_push.glsl"

layout(location = 0) flat in uint beam_index;
layout(location = 0) out vec4 light; // W/(m2 sr) at the camera, and 1 to count by

void count(uint what) {}

float seen_through(Stretch s, float distance) {
    return density_along(s.medium, s.origin, s.direction, distance);
}

void main() {
    uint slot = uint(gl_FragCoord.y) * view.width + uint(gl_FragCoord.x);
    light = vec4(0.0, 0.0, 0.0, 1.0);
    Stretch s = stretch(0u, slot, view.width * view.rows * VISIBLE_LAYERS);
    if (s.medium == NO_MEDIUM || s.origin != view.position) return;
    light.rgb = volume_light(push.shade, push.volume, beams[beam_index], s);
}
