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

#ifndef EVEN_MEDIA
float seen_through(Stretch s, float distance) {
    return density_along(s.medium, s.origin, s.direction, distance);
}
#endif

void main() {
    uint slot = uint(gl_FragCoord.y) * view.width + uint(gl_FragCoord.x);
    light = vec4(0.0, 0.0, 0.0, 1.0);
    Stretch s = stretch(0u, slot, view.width * view.rows * VISIBLE_LAYERS);
    if (s.medium == NO_MEDIUM || s.origin != view.position) return;
    Beam beam = beams[beam_index];
    if (!may_light(beam, s)) return;
    vec2 seen = seen_part(s);
    if ((beam.flags & BEAM_STRADDLES) != 0u && is_hidden(push.volume, beam, s, seen)) return;
    float from = -ALL_DONE;
    while (from < ALL_DONE) light.rgb += volume_step(push.shade, push.volume, beam_index, beam, s, seen, from);
}
