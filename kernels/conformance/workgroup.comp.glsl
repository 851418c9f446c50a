// Sums of all words before each one of a workgroup's, by halves, in shared memory.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };

shared uint sums[gl_WorkGroupSize.x];

void main() {
    uint i = linear_index();
    uint place = gl_LocalInvocationID.x;
    sums[place] = i < push.count ? words[i] : 0u;
    barrier();
    for (uint reach = 1u; reach < gl_WorkGroupSize.x; reach *= 2u) {
        uint other = place >= reach ? sums[place - reach] : 0u;
        barrier();
        sums[place] += other;
        barrier();
    }
    if (i < push.count) words[i] = sums[place];
}
