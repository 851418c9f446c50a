// Prefix sums of the blocks' totals, at most 1024 of them, by one workgroup.
#include "technique/reference/common.glsl"
#include "shared/scan.glsl"

layout(set = 3, binding = 8, std430) buffer BlockSums { uint block_sums[]; };
layout(push_constant) uniform ScanPush { uint blocks; } push;

void main() {
    uint first = gl_LocalInvocationIndex * SCAN_PER_INVOCATION;
    uint numbers[SCAN_PER_INVOCATION];
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) numbers[i] = first + i < push.blocks ? block_sums[first + i] : 0u;
    scan_group(numbers);
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) {
        if (first + i < push.blocks) block_sums[first + i] = numbers[i];
    }
}
