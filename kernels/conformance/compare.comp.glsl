// What comparisons of two numbers say, a bit each.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Operands { vec4 operands[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Gathered { uint gathered[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    float x = operands[i].x, y = operands[i].y;
    uint said = 0u;
    if (x < y) said |= 1u;
    if (x <= y) said |= 2u;
    if (x > y) said |= 4u;
    if (x >= y) said |= 8u;
    if (x == y) said |= 16u;
    if (x != y) said |= 32u;
    if (!(x < y)) said |= 64u;
    if (!(x >= y)) said |= 128u;
    // Whether a hit at x is in a range that begins at y, as traversal asks.
    if (x > y && x < operands[i].z) said |= 256u;
    // By bits, as kernels find what is not finite.
    if ((floatBitsToUint(x) & 0x7f800000u) == 0x7f800000u) said |= 512u;
    gathered[i] = said;
}
