// One turn of a sweep along the light's way: cells are visited plane by plane and, in each, outward from the column under
// the light or towards it, so that light which goes that way finds each cell's neighbours done before the cell. Further visits
// follow behind the first. Cells that are visited in one turn do not look at each other.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };

#include "technique/eikonal/update.glsl"

layout(push_constant) uniform SweepPush {
    EikonalSweep sweep;
} push;

void main() {
    EikonalSweep sweep = push.sweep;
    EikonalGrid grid = volumes[sweep.volume].grid;
    uint columns = grid.cells.x * grid.cells.y;
    uint index = linear_index();
    if (index >= columns * sweep.visits) return;
    uint column = index % columns;
    ivec3 at = ivec3(column % grid.cells.x, column / grid.cells.x, 0);
    ivec2 off = abs(at.xy - sweep.foot);
    ivec2 farthest = max(sweep.foot, ivec2(grid.cells.xy) - 1 - sweep.foot);
    if ((sweep.inward & 1u) != 0u) off.x = farthest.x - off.x;
    if ((sweep.inward & 2u) != 0u) off.y = farthest.y - off.y;
    at.z = int(sweep.turn) - SPACING * int(index / columns) - off.x - off.y;
    if (at.z < 0 || at.z >= int(grid.cells.z)) return;
    int cell = cell_index(grid, at);
    uint known = values[cell];
    if ((known & GIVEN) != 0u || known == floatBitsToUint(OUTSIDE)) return;
    float value = updated(sweep, grid, at, cell);
    // Of first order values only fall. Differences of second order do not promise that.
    if (sweep.order == 1u) value = min(value, uintBitsToFloat(known));
    values[cell] = floatBitsToUint(value);
}
