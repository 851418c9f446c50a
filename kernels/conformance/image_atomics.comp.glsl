// Adds to the pixels of an image, a wide, that many invocations share.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, r32ui) uniform uimage2D counters;

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    uint pixel = i % (push.a * push.b);
    imageAtomicAdd(counters, ivec2(pixel % push.a, pixel / push.a), mix_bits(i) & 0xffffu);
}
