// Writes points of the scrambled sequence, for comparison with the host's.
#include "shared/index.glsl"
#include "shared/random.glsl"

layout(set = 0, binding = 0, std430) writeonly buffer Points { vec2 points[]; };
layout(push_constant) uniform RandomPush { uint seed; uint count; } push;

void main() {
    uint index = linear_index();
    if (index < push.count) points[index] = sample_2d(index, combine(push.seed, index / 256u));
}
