// Adds to each bucket what lies in the blocks before its own.
#include "technique/reference/common.glsl"

layout(set = 3, binding = 5, std430) buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 8, std430) readonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint bucket = linear_index();
    bucket_starts[bucket] += block_sums[bucket / 1024u];
}
