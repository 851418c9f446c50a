// Prefix sums within blocks of 1024 buckets; each block's total goes to `block_sums`.
#include "technique/reference/common.glsl"
#include "shared/scan.glsl"

layout(set = 3, binding = 5, std430) buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 8, std430) writeonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint first = (linear_index() / 64u) * SCAN_PER_GROUP + gl_LocalInvocationIndex * SCAN_PER_INVOCATION;
    uint numbers[SCAN_PER_INVOCATION];
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) numbers[i] = bucket_starts[first + i];
    uint total = scan_group(numbers);
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) bucket_starts[first + i] = numbers[i];
    if (gl_LocalInvocationIndex == 0u) block_sums[linear_index() / 64u] = total;
}
