// The device's counters.
#include "technique/beams/tally_names.glsl"

layout(set = 3, binding = 3, std430) buffer BeamTallies { uint beam_tallies[]; };

void tally(uint what, uint amount) {
    if (amount == 0u) return;
    uint before = atomicAdd(beam_tallies[2u * what], amount);
    if (before + amount < before) atomicAdd(beam_tallies[2u * what + 1u], 1u);
}
