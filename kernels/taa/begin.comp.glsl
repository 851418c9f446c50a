// Ways back begin with the motion of the frame at hand, and what is measured along them with its light, one invocation a
// pixel.
#include "shared/index.glsl"
#include "taa/common.glsl"

layout(set = 3, binding = 0, std430) readonly buffer TaaLights { TaaLight taa_lights[]; };
layout(set = 3, binding = 1, std430) readonly buffer TaaSeens { TaaSeen taa_seens[]; };
layout(set = 3, binding = 2, std430) writeonly buffer TaaPlaces { TaaPlace taa_places[]; };
layout(set = 3, binding = 6, std430) writeonly buffer TaaRuns { TaaRun taa_runs[]; };
layout(set = 3, binding = 7, std430) writeonly buffer TaaFound { uint taa_found[]; }; // frames on the way back
layout(push_constant) uniform BeginPush { TaaPush push; };

void main() {
    uint pixel = linear_index();
    if (pixel >= push.width * push.height) return;
    float luma = to_luma(taa_lights[pixel].radiance).x;
    taa_runs[pixel] = TaaRun(luma, luma, 0.0, 0.0);
    taa_found[pixel] = 0u;
    taa_places[pixel] = first_place(pixel, push.width, taa_lights[pixel], taa_seens[pixel]);
}
