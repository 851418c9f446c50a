// The film as 8-bit sRGB: final radiance times the exposure, through the tone curve. As renderer/image/tone.rs does it.
#include "shared/film_radiance.glsl"
#include "shared/index.glsl"
#include "shared/math.glsl"

struct DisplayPush {
    uint pixels;
    uint curve;     // 0: linear, 1: Reinhard
    float samples;  // that the film's direct light is the sum of
    float gain;
    float white;    // luminance that Reinhard's curve sends to 1
    uint volume;    // 1: the film has light that media scatter
    uint summed;    // 1: the picture is in sums made of several frames, and not in the film
    uint padding1;
};
layout(set = 2, binding = 0, std430) writeonly buffer DisplayPixels { uint display_pixels[]; };
layout(set = 2, binding = 20, std430) readonly buffer TaaSums { vec4 taa_sums[]; }; // radiance times weight, weight
layout(push_constant) uniform DisplayPushes { DisplayPush push; };

const uint CURVE_REINHARD = 1u;

float srgb(float linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * pow(linear, 1.0 / 2.4) - 0.055;
}

void main() {
    uint pixel = linear_index();
    if (pixel >= push.pixels) return;
    vec3 color;
    if (push.summed != 0u) {
        color = taa_sums[pixel].rgb / taa_sums[pixel].w;
    } else {
        color = film_radiance(pixel, push.pixels, push.samples, push.volume != 0u);
    }
    color *= push.gain;
    float luminance = dot(color, vec3(0.2126, 0.7152, 0.0722));
    if (push.curve == CURVE_REINHARD && luminance > 0.0) {
        color *= (1.0 + luminance / (push.white * push.white)) / (1.0 + luminance);
    }
    // clamp() leaves it open what becomes of a NaN.
    color = all_finite(color) ? clamp(color, 0.0, 1.0) : vec3(0.0);
    uvec3 bytes = uvec3(vec3(srgb(color.r), srgb(color.g), srgb(color.b)) * 255.0 + 0.5);
    display_pixels[pixel] = bytes.r | bytes.g << 8 | bytes.b << 16 | 255u << 24;
}
