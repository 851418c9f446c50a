// What the kernels of the conformance cases have in common.
#include "shared/index.glsl"

layout(push_constant) uniform ConformancePush {
    uint count; // invocations that have work
    uint a;
    uint b;
    uint c;
} push;

// The finaliser of shared/random.glsl.
uint mix_bits(uint x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}
