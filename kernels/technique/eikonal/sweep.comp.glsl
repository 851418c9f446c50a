// One turn of a sweep along the light's way: cells are visited plane by plane and, in each, outward from the column under
// the light, so that light which goes on as it came finds each cell's neighbours done before the cell. Cells that are visited
// in one turn do not look at each other.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) buffer EikonalSides { float sides[]; };

#include "technique/eikonal/update.glsl"
#include "technique/eikonal/block.glsl"

layout(push_constant) uniform SweepPush {
    EikonalSweep sweep;
} push;

void main() {
    ivec2 column;
    int block;
    if (outward_block(push.sweep, linear_index(), column, block)) visit(push.sweep, column, block);
}
