// A beam's light at a visible point that the camera sees straight, for each pixel of its hull.
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "technique/beams/surface_light.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/hull_push.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };
layout(location = 0) flat in uint beam_index;
layout(location = 0) out vec4 light; // W/m2, and 1 to count by

void count(uint what) {}

void main() {
    uint slot = uint(gl_FragCoord.y) * view.width + uint(gl_FragCoord.x);
    light = vec4(0.0, 0.0, 0.0, 1.0);
    VisiblePoint point = visible_points[slot];
    if (point.instance == NO_INSTANCE || visible_shades[slot].events != 0u) return;
    Beam beam = beams[beam_index];
    Section section;
    if (holds_point(beam, point, section)) light.rgb = surface_light(push.shade, beam, point, section);
}
