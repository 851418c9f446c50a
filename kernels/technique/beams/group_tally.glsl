// Counting by a workgroup of 64, which adds to the device's counters once.
#include "technique/beams/tally.glsl"

shared uint group_tallies[TALLIES];
uint own_tallies[TALLIES] = uint[TALLIES](0u, 0u, 0u, 0u, 0u, 0u);

// Before a barrier.
void open_tallies() {
    if (gl_LocalInvocationIndex < TALLIES) group_tallies[gl_LocalInvocationIndex] = 0u;
}

void count(uint what) {
    own_tallies[what]++;
}

void count_drawn(float fragments) {
    own_tallies[TALLY_DRAWN] += uint(fragments);
}

// In uniform control flow.
void close_tallies() {
    for (uint i = 0u; i < TALLIES; i++) {
        if (own_tallies[i] > 0u) atomicAdd(group_tallies[i], own_tallies[i]);
    }
    barrier();
    if (gl_LocalInvocationIndex < TALLIES) tally(gl_LocalInvocationIndex, group_tallies[gl_LocalInvocationIndex]);
}
