// How much of the past a pixel takes, one invocation a pixel. Sums begin with the frame at hand, and ways back begin again.
//
// Weights fall the further back a frame is where the two halves of the window differ by more than successive frames do:
// what is only noise differs from frame to frame as much as from half to half, and light that moves adds up. They fall
// alike where the frame at hand is brighter or darker than the past all around: a lamp was switched.
#include "shared/index.glsl"
#include "taa/common.glsl"

layout(set = 3, binding = 0, std430) readonly buffer TaaLights { TaaLight taa_lights[]; };
layout(set = 3, binding = 1, std430) readonly buffer TaaSeens { TaaSeen taa_seens[]; };
layout(set = 3, binding = 2, std430) writeonly buffer TaaPlaces { TaaPlace taa_places[]; };
layout(set = 3, binding = 3, std430) writeonly buffer TaaSums { vec4 taa_sums[]; };
layout(set = 3, binding = 6, std430) readonly buffer TaaRuns { TaaRun taa_runs[]; };
layout(set = 3, binding = 7, std430) readonly buffer TaaFound { uint taa_found[]; };
layout(set = 3, binding = 8, std430) writeonly buffer TaaWeights { vec2 taa_weights[]; }; // of all frames; and from one to the next
layout(push_constant) uniform WeighPush { TaaPush push; };

// How fast weights fall with what is seen of the halves' difference over what noise explains. 0.25 leaves more lag where
// water moves, 1 more noise where it stands.
const float DOUBT = 0.5;
// Square of the deviations by which the mean of 5 x 5 pixels may differ from the past. Noise of neighbours is alike, since
// they share their jitter: 4 would take much of it for a change.
const float SWITCHED = 9.0;

void main() {
    uint pixel = linear_index();
    if (pixel >= push.width * push.height) return;
    ivec2 centre = ivec2(pixel % push.width, pixel / push.width);
    float halves = 0.0;  // squared difference of the halves' means, over 3 x 3 pixels
    float noise = 0.0;   // that of independent frames which differ as successive ones do
    float change = 0.0;  // of the frame at hand from the mean of the past, over 5 x 5 pixels
    float changes = 0.0; // squared, what independent pixels would have of it
    for (int i = 0; i < 25; i++) {
        ivec2 away = ivec2(i % 5, i / 5) - 2;
        ivec2 at = centre + away;
        if (at.x < 0 || at.y < 0 || at.x >= int(push.width) || at.y >= int(push.height)) continue;
        uint index = uint(at.y) * push.width + uint(at.x);
        uint found = taa_found[index];
        if (found == 0u) continue;
        TaaRun run = taa_runs[index];
        float variance = run.steps / float(2u * found);
        float now = to_luma(taa_lights[index].radiance).x;
        change += now - (run.recent + run.older - now) / float(found);
        changes += variance * (1.0 + 1.0 / float(found));
        if (max(abs(away.x), abs(away.y)) > 1 || found < push.half_way) continue;
        float newer = float(push.half_way);
        float older = float(found + 1u - push.half_way);
        float difference = run.recent / newer - run.older / older;
        halves += difference * difference;
        noise += variance * (1.0 / newer + 1.0 / older);
    }
    float excess = halves > noise ? halves / max(noise, 1e-30) - 1.0 : 0.0;
    float switched = change * change > SWITCHED * changes ? change * change / max(SWITCHED * changes, 1e-30) - 1.0 : 0.0;
    taa_weights[pixel] = vec2(1.0 / (1.0 + switched), 1.0 / (1.0 + DOUBT * excess));
    taa_sums[pixel] = vec4(push.weight * taa_lights[pixel].radiance, push.weight);
    taa_places[pixel] = first_place(pixel, push.width, taa_lights[pixel], taa_seens[pixel]);
}
