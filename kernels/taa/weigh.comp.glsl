// How much of the past a pixel takes, one invocation a pixel: less where the two halves of its frames differ by more than
// successive frames do. What is only noise differs from frame to frame as much as from half to half; light that moves
// adds up. Sums begin with the frame at hand, and ways back begin again.
#include "shared/index.glsl"
#include "taa/common.glsl"

layout(set = 3, binding = 0, std430) readonly buffer TaaLights { TaaLight taa_lights[]; };
layout(set = 3, binding = 1, std430) readonly buffer TaaSeens { TaaSeen taa_seens[]; };
layout(set = 3, binding = 2, std430) writeonly buffer TaaPlaces { TaaPlace taa_places[]; };
layout(set = 3, binding = 3, std430) writeonly buffer TaaSums { vec4 taa_sums[]; };
layout(set = 3, binding = 6, std430) readonly buffer TaaRuns { TaaRun taa_runs[]; };
layout(set = 3, binding = 7, std430) readonly buffer TaaFound { uint taa_found[]; };
layout(set = 3, binding = 8, std430) writeonly buffer TaaWeights { float taa_weights[]; };
layout(push_constant) uniform WeighPush { TaaPush push; };

// How fast weights fall with what is seen of the difference over what noise explains. 0.25 leaves more lag where water
// moves, 1 more noise where it stands.
const float DOUBT = 0.5;

void main() {
    uint pixel = linear_index();
    if (pixel >= push.width * push.height) return;
    ivec2 centre = ivec2(pixel % push.width, pixel / push.width);
    float halves = 0.0; // squared difference of the halves' means, over 3 x 3 pixels
    float noise = 0.0;  // that of independent frames which differ as successive ones do
    for (int i = 0; i < 9; i++) {
        ivec2 at = centre + ivec2(i % 3, i / 3) - 1;
        if (at.x < 0 || at.y < 0 || at.x >= int(push.width) || at.y >= int(push.height)) continue;
        uint index = uint(at.y) * push.width + uint(at.x);
        uint found = taa_found[index];
        if (found < push.half_way) continue; // nothing in the older half
        TaaRun run = taa_runs[index];
        float newer = float(push.half_way);
        float older = float(found + 1u - push.half_way);
        float difference = run.recent / newer - run.older / older;
        halves += difference * difference;
        noise += run.steps / float(2u * found) * (1.0 / newer + 1.0 / older);
    }
    float excess = halves > noise ? halves / max(noise, 1e-30) - 1.0 : 0.0;
    taa_weights[pixel] = 1.0 / (1.0 + DOUBT * excess);
    taa_sums[pixel] = vec4(push.weight * taa_lights[pixel].radiance, push.weight);
    taa_places[pixel] = first_place(pixel, push.width, taa_lights[pixel], taa_seens[pixel]);
}
