// One level of the edge-avoiding wavelet (Dammertz et al. 2010; Schied et al. 2017, section 4.3). A texel takes from each
// neighbour a part of the difference to it, and gives as much: where the paper divides by the sum of weights, which keeps no
// flux, the texel's own weight is what the others leave.
#include "technique/photons/denoise.glsl"

layout(set = 3, binding = 17, std430) writeonly buffer FilterTo { vec4 filter_to[]; }; // irradiance, variance
layout(set = 3, binding = 18, std430) readonly buffer FilterFrom { vec4 filter_from[]; };
layout(set = 3, binding = 19, std430) readonly buffer FilterGuides { vec2 filter_guides[]; }; // deviation, luminance

// The spline's weights, 1/16, 1/4, 3/8, 1/4, 1/16.
float spline(int step) {
    return step == 0 ? 0.375 : abs(step) == 1 ? 0.25 : 0.0625;
}

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    ivec2 texel = ivec2(index % v.columns, index / v.columns);
    CameraTexel seen = camera_texels[index];
    vec4 own = filter_from[index];
    vec4 result = own;
    if (seen.instance != NO_INSTANCE) {
        Shown here = shown_at(v, seen, uvec2(texel));
        float area = texel_area(v, index);
        vec2 guide = filter_guides[index];
        vec3 gained = vec3(0.0);
        float given = 0.0;
        float variance = 0.0;
        for (int i = 0; i < 25; i++) {
            ivec2 step = ivec2(i % 5, i / 5) - 2;
            ivec2 at = texel + step * int(push.stride);
            if (step == ivec2(0) || any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(v.columns, v.rows)))) {
                continue;
            }
            uint tap = uint(at.y) * v.columns + uint(at.x);
            CameraTexel other = camera_texels[tap];
            if (other.instance == NO_INSTANCE) continue;
            vec4 theirs = filter_from[tap];
            vec2 theirs_guide = filter_guides[tap];
            // As in the paper where both deviate alike.
            float deviation = sqrt(0.5 * (guide.x * guide.x + theirs_guide.x * theirs_guide.x));
            float stop = exp(-abs(theirs_guide.y - guide.y) / max(push.sigma * deviation, 1e-30));
            if (push.sigma <= 0.0) stop = 0.0;
            float weight = spline(step.x) * spline(step.y) * stop * alike(here, shown_at(v, other, uvec2(at)));
            // Of the flux that the smaller of both has.
            float theirs_area = texel_area(v, tap);
            weight *= min(area, theirs_area) / area;
            gained += weight * (theirs.rgb - own.rgb);
            given += weight;
            variance += weight * weight * theirs.a;
        }
        result = vec4(max(own.rgb + gained, vec3(0.0)), (1.0 - given) * (1.0 - given) * own.a + variance);
    }
    filter_to[index] = result;
}
