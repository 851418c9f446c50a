// Lists the samples of an adaptive round, one invocation a pixel: in the pilot one of each pixel, later what the plan
// gives it.
#include "shared/index.glsl"
#include "shared/view.glsl"
#include "shared/round.glsl"

layout(set = 2, binding = 5, std430) readonly buffer PixelPlans { PixelPlan pixel_plans[]; };
layout(push_constant) uniform ListPush { RoundPush push; };

void main() {
    uint pixel = linear_index();
    uint pixels = view.width * view.rows;
    if (pixel >= pixels) return;
    Places places = places_of(pixel, pixel_plans[pixel], push, pixels);
    for (uint place = places.from; place < places.to; place++) {
        round_samples[place] = RoundSample(pixel, places.taken + place - places.from, vec2(0.0));
    }
}
