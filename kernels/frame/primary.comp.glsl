// What each pixel sees first, by rays: the fallback of frame/visibility where there is no graphics.
#include "shared/index.glsl"
#include "shared/scene.glsl"
#include "shared/random.glsl"
#include "shared/view.glsl"
#include "shared/round.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 1, std430) writeonly buffer PrimaryIds { uvec2 primary_ids[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

void main() {
    uint place = linear_index();
    if (place >= view.width * view.rows) return;
    uint pixel = place;
    vec2 jitter = frame.jitter;
    if (frame.listed != 0u) {
        RoundSample s = round_samples[place];
        pixel = s.pixel;
        // 2: the layers' walks have the seeds 0 and 1.
        jitter = sample_2d(s.index, combine(combine(view.seed, pixel + view.first_row * view.width), 2u));
        round_samples[place].jitter = jitter;
    }
    vec3 direction = pixel_direction(uvec2(pixel % view.width, pixel / view.width), jitter);
    Hit hit = trace_closest(Ray(view.position, 0.0, direction, 1e30), MASK_ALL);
    primary_ids[place] = hit.instance == NO_INSTANCE ? uvec2(0u) : uvec2(hit.instance + 1u, hit.primitive);
}
