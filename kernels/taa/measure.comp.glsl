// How light has changed along each pixel's way back, by one frame of the past more, one invocation a pixel.
#include "shared/index.glsl"
#include "taa/common.glsl"
#include "taa/follow.glsl"

layout(set = 3, binding = 6, std430) buffer TaaRuns { TaaRun taa_runs[]; };
layout(set = 3, binding = 7, std430) buffer TaaFound { uint taa_found[]; };

void main() {
    uint pixel = linear_index();
    if (pixel >= push.width * push.height) return;
    vec3 light;
    if (!follow(pixel, light)) return;
    float luma = to_luma(light).x;
    TaaRun run = taa_runs[pixel];
    float step = luma - run.last;
    run.steps += step * step;
    run.last = luma;
    if (push.back < push.half_way) {
        run.recent += luma;
    } else {
        run.older += luma;
    }
    taa_runs[pixel] = run;
    taa_found[pixel] = push.back;
}
