// Counts the beams of each sheet in blocks of 64 leaves.
#include "technique/beams/edges.glsl"
#include "technique/beams/block.glsl"
#include "technique/beams/sizes.glsl"

layout(set = 3, binding = 12, std430) writeonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint blocks = max(sizes[SIZE_LEAVES].w, 1u);
    uint group = linear_index() / 64u;
    uint sheet = group / blocks;
    uint leaf = group % blocks * 64u + gl_LocalInvocationIndex;
    bool found = sheet < settings.sheets && sheet_counts[sheet] > 0u && leaf < state.leaves;
    if (found) found = brings_light(edges_of(beam_leaves[leaf], sheet));
    place_in_block(found);
    if (gl_LocalInvocationIndex == 0u && sheet < settings.sheets) block_sums[group] = block_total();
}
