// What each pixel sees first, by rays: the fallback of frame/visibility where there is no graphics.
#include "shared/index.glsl"
#include "shared/scene.glsl"
#include "shared/view.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 1, std430) writeonly buffer PrimaryIds { uvec2 primary_ids[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

void main() {
    uint pixel = linear_index();
    if (pixel >= view.width * view.rows) return;
    vec3 direction = pixel_direction(uvec2(pixel % view.width, pixel / view.width), frame.jitter);
    Hit hit = trace_closest(Ray(view.position, 0.0, direction, 1e30), MASK_ALL);
    primary_ids[pixel] = hit.instance == NO_INSTANCE ? uvec2(0u) : uvec2(hit.instance + 1u, hit.primitive);
}
