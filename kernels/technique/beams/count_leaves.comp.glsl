// Counts leaves in blocks of 64 places.
#include "technique/beams/nodes.glsl"
#include "technique/beams/block.glsl"

layout(set = 3, binding = 12, std430) writeonly buffer BlockSums { uint block_sums[]; };

void main() {
    uint place = linear_index();
    uint view;
    ivec2 a, b, c;
    bool found = place < leaf_places() && leaf_at(place, view, a, b, c);
    place_in_block(found);
    if (gl_LocalInvocationIndex == 0u && place < leaf_places()) block_sums[place / 64u] = block_total();
}
