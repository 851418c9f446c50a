// A frame's radiance so far, and the motion of what each pixel's centre shows: one invocation a pixel of the band, for the
// whole picture's buffers.
#include "shared/film_radiance.glsl"
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/motion.glsl"
#include "taa/common.glsl"

struct TaaTakePush {
    float samples; // that direct light is the sum of, where every pixel has as many
    uint counted;  // 1: each pixel has its own number
    uint volume;   // 1: the film has light that media scatter
    uint padding0;
};
layout(set = 3, binding = 3, std430) readonly buffer SampleCounts { uint sample_counts[]; };
layout(set = 3, binding = 4, std430) writeonly buffer TaaLights { TaaLight taa_lights[]; };
layout(set = 3, binding = 5, std430) writeonly buffer TaaSeens { TaaSeen taa_seens[]; };
layout(push_constant) uniform TakePush { TaaTakePush push; };

void main() {
    uint index = linear_index();
    uint pixels = view.width * view.rows;
    if (index >= pixels) return;
    float samples = push.counted != 0u ? float(max(sample_counts[index], 1u)) : push.samples;
    vec3 radiance = film_radiance(index, pixels, samples, push.volume != 0u);
    if (!all_finite(radiance)) radiance = vec3(0.0);
    Motion m = motion_of(index);
    uint pixel = view.first_row * view.width + index;
    taa_lights[pixel] = TaaLight(radiance, m.instance);
    taa_seens[pixel] = TaaSeen(m.moved, m.distance, m.was_before ? m.then : -1.0);
}
