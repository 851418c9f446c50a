// Adds a frame of the past to the sums, one invocation a pixel.
#include "shared/index.glsl"
#include "taa/common.glsl"
#include "taa/follow.glsl"

layout(set = 3, binding = 0, std430) readonly buffer TaaLights { TaaLight taa_lights[]; }; // of the frame at hand
layout(set = 3, binding = 3, std430) buffer TaaSums { vec4 taa_sums[]; };
layout(set = 3, binding = 8, std430) readonly buffer TaaWeights { vec2 taa_weights[]; };

// Standard deviations of the pixels around, in each of luma and two chromas, that light of the past is kept within. With
// 1.5, still pictures lose three times as much of their light.
const float CLIP = 3.0;

// Drawn towards the mean of the pixels around until it is within their spread (Salvi 2016), so that light which has gone
// leaves no trail where all is even.
vec3 clipped(vec3 light, ivec2 centre) {
    vec3 sum = vec3(0.0);
    vec3 squares = vec3(0.0);
    float count = 0.0;
    for (int i = 0; i < 9; i++) {
        ivec2 at = centre + ivec2(i % 3, i / 3) - 1;
        if (!inside(at)) continue;
        vec3 c = to_luma(taa_lights[index_of(at)].radiance);
        sum += c;
        squares += c * c;
        count += 1.0;
    }
    vec3 middle = sum / count;
    vec3 room = CLIP * sqrt(max(squares / count - middle * middle, vec3(0.0)));
    vec3 away = to_luma(light) - middle;
    float part = 1.0;
    for (int i = 0; i < 3; i++) {
        if (abs(away[i]) > room[i]) part = min(part, room[i] / abs(away[i]));
    }
    return part < 1.0 ? from_luma(middle + part * away) : light;
}

void main() {
    uint pixel = linear_index();
    if (pixel >= push.width * push.height) return;
    vec3 light;
    if (!follow(pixel, light)) return;
    light = clipped(light, ivec2(pixel % push.width, pixel / push.width));
    float weight = taa_weights[pixel].x;
    for (uint i = 0u; i < push.back; i++) weight *= taa_weights[pixel].y;
    taa_sums[pixel] += weight * vec4(light, 1.0);
}
