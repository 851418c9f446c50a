// Counts the photons of each bucket, and gives each photon its place in it.
#include "technique/reference/common.glsl"

layout(set = 3, binding = 3, std430) readonly buffer Photons { Photon photons[]; };
layout(set = 3, binding = 5, std430) buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 6, std430) writeonly buffer Places { uint places[]; };
layout(push_constant) uniform GridPush { uint slots; uint buckets; } push;

void main() {
    uint slot = linear_index();
    if (slot >= push.slots || photons[slot].landed == 0u) return;
    uint bucket = bucket_of(cell_of(photons[slot].position, cell_size()), push.buckets);
    places[slot] = atomicAdd(bucket_starts[bucket], 1u);
}
