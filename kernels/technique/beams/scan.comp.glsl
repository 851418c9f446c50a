// Prefix sums of block totals, by one workgroup, 1024 at a time.
#include "technique/beams/common.glsl"
#include "shared/scan.glsl"

layout(set = 3, binding = 12, std430) buffer BlockSums { uint block_sums[]; };
#include "technique/beams/sizes.glsl"
layout(push_constant) uniform BeamScanPush {
    uint blocks; // of places; those of leaves are counted on the device
    uint total;  // where the sum of all goes: 0 leaves, 1 beams
} push;

void main() {
    uint blocks = push.total == 0u ? push.blocks : sizes[SIZE_SHEETS].w;
    uint carry = 0u;
    for (uint chunk = 0u; chunk < blocks; chunk += SCAN_PER_GROUP) {
        uint first = chunk + gl_LocalInvocationIndex * SCAN_PER_INVOCATION;
        uint numbers[SCAN_PER_INVOCATION];
        for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) numbers[i] = first + i < blocks ? block_sums[first + i] : 0u;
        uint total = scan_group(numbers);
        for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) {
            if (first + i < blocks) block_sums[first + i] = carry + numbers[i];
        }
        carry += total;
        barrier();
    }
    if (gl_LocalInvocationIndex == 0u) scan_totals[push.total] = carry;
}
