// One turn of a sweep along the light's way: cells are visited plane by plane and, in each, outward from the column under
// the light, so that light which goes on as it came finds each cell's neighbours done before the cell. Further visits follow
// behind the first. Cells that are visited in one turn do not look at each other.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) buffer EikonalSides { float sides[]; };

#include "technique/eikonal/update.glsl"
#include "technique/eikonal/block.glsl"

layout(push_constant) uniform SweepPush {
    EikonalSweep sweep;
} push;

// Levels from one visit of a cell to its next: what is at work at the same time is never within two cells of each other.
const int SPACING = 3;

void main() {
    EikonalSweep sweep = push.sweep;
    uint index = linear_index();
    if (index >= sweep.cells.x * sweep.cells.y * (sweep.options >> SWEEP_VISITS)) return;
    ivec2 column = column_of(index, sweep.cells.x);
    int again = int((float(column.y) + 0.5) / float(sweep.cells.y));
    column.y -= again * int(sweep.cells.y);
    ivec2 off = abs(column - sweep.foot);
    int block = int(sweep.turn) - SPACING * again - off.x - off.y;
    if (block < 0 || block * BLOCK >= int(sweep.cells.z)) return;
    visit(sweep, column, block);
}
