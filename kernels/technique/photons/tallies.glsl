// How often what, in two words each; renderer/technique/photons/ledger.rs has the names in this order. A workgroup of 64
// adds up first: all photons count.
layout(set = 3, binding = 10, std430) buffer PhotonTallies { uint photon_tallies[]; };

const uint TALLY_TRACED = 0u;       // photons that left a specular surface
const uint TALLY_LIGHT_STEPS = 1u;  // nodes and texels looked at in lights' views
const uint TALLY_CAMERA_STEPS = 2u; // and in the camera's
const uint TALLY_LIGHT_HITS = 3u;
const uint TALLY_CAMERA_HITS = 4u;
const uint TALLY_SKIMMING = 5u;     // photons whose light grazes what they land on
const uint TALLY_LONG = 6u;         // marches that took more steps than are taken
const uint TALLY_FULL = 7u;         // photons for which a table or list had no room
const uint TALLY_REFRACTIONS = 8u; // pixels that are refracted in screen space
const uint TALLY_UNBENT = 9u;      // of them, those whose ray meets nothing that the view shows
const uint TALLIES = 10u;

shared uint group_tallies[TALLIES];

// Before a barrier.
void open_tallies() {
    if (gl_LocalInvocationIndex < TALLIES) group_tallies[gl_LocalInvocationIndex] = 0u;
}

void count(uint what, uint amount) {
    if (amount > 0u) atomicAdd(group_tallies[what], amount);
}

// In uniform control flow.
void close_tallies() {
    barrier();
    if (gl_LocalInvocationIndex >= TALLIES) return;
    uint amount = group_tallies[gl_LocalInvocationIndex];
    uint at = 2u * gl_LocalInvocationIndex;
    uint before = atomicAdd(photon_tallies[at], amount);
    if (before + amount < before) atomicAdd(photon_tallies[at + 1u], 1u);
}
