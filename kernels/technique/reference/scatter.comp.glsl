// Sorts the photons by bucket.
#include "technique/reference/common.glsl"

layout(set = 3, binding = 3, std430) readonly buffer Photons { Photon photons[]; };
layout(set = 3, binding = 5, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 6, std430) readonly buffer Places { uint places[]; };
layout(set = 3, binding = 7, std430) writeonly buffer SortedPhotons { Photon sorted_photons[]; };
layout(push_constant) uniform GridPush { uint slots; uint buckets; } push;

void main() {
    uint slot = linear_index();
    if (slot >= push.slots || photons[slot].landed == 0u) return;
    uint bucket = bucket_of(cell_of(photons[slot].position, cell_size()), push.buckets);
    sorted_photons[bucket_starts[bucket] + places[slot]] = photons[slot];
}
