// A per-sample technique for tests: irradiance of mean 1 over every pixel. Of 32 columns of pixels eight hold a spike on
// 1/64 of each pixel, in a different place in each; eight hold a step; the others are even.
#include "shared/index.glsl"
#include "shared/random.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/round.glsl"

layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };

const float SPIKE_SIDE = 0.125; // pixels

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    RoundSample at = round_samples[slot % pixels];
    vec2 corner = sample_2d(0u, combine(99u, at.pixel));
    // Wrapped round the pixel's edges, so that the spike is whole wherever it lies.
    bool spike = all(lessThan(fract(at.jitter - corner), vec2(SPIKE_SIDE)));
    uint kind = at.pixel % view.width / 8u % 4u;
    float found = 1.0;
    if (kind == 0u) found = spike ? 1.0 / (SPIKE_SIDE * SPIKE_SIDE) : 0.0;
    if (kind == 1u) found = at.jitter.x + at.jitter.y < 1.0 ? 2.0 : 0.0;
    sample_irradiance[slot] = vec4(found);
}
