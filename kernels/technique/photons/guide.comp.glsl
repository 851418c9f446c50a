// What the wavelet's stops for light go by: the standard deviation from the variance over 3 x 3 texels (Schied et al. 2017,
// section 4.4), since a texel's own is too noisy, and the luminance over the same. The paper takes a texel's own luminance;
// where photons are fewer than texels, each is many deviations above its neighbours and would not be spread.
#include "technique/photons/denoise.glsl"

layout(set = 3, binding = 18, std430) readonly buffer FilterFrom { vec4 filter_from[]; };
layout(set = 3, binding = 19, std430) writeonly buffer FilterGuides { vec2 filter_guides[]; }; // deviation, luminance

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    ivec2 texel = ivec2(index % v.columns, index / v.columns);
    uint instance = camera_texels[index].instance;
    vec2 sum = vec2(0.0);
    float weights = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 step = ivec2(i % 3, i / 3) - 1;
        ivec2 at = texel + step;
        if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(v.columns, v.rows)))) continue;
        uint tap = uint(at.y) * v.columns + uint(at.x);
        if (camera_texels[tap].instance != instance) continue;
        float weight = (step.x == 0 ? 2.0 : 1.0) * (step.y == 0 ? 2.0 : 1.0);
        vec4 light = filter_from[tap];
        sum += weight * vec2(light.a, luminance(light.rgb));
        weights += weight;
    }
    filter_guides[index] = vec2(sqrt(sum.x / weights), sum.y / weights);
}
