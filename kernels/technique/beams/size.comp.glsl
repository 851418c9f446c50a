// Sets the indirect dispatches over leaves and over rays, and how many blocks of leaves there are.
#include "technique/beams/common.glsl"
#include "technique/beams/sizes.glsl"

uvec4 groups(uint number) {
    return uvec4(min(number, 65535u), (number + 65534u) / 65535u, 1u, number);
}

void main() {
    if (linear_index() != 0u) return;
    state.leaves = min(scan_totals[0], settings.leaves);
    uint blocks = (state.leaves + 63u) / 64u;
    sizes[SIZE_LEAVES] = groups(blocks);
    sizes[SIZE_SHEETS] = groups(blocks * settings.sheets);
    sizes[SIZE_RAYS] = groups((min(state.vertices, settings.vertices) * settings.sheets + 63u) / 64u);
}
