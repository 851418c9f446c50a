// How far cells are from what their neighbours say.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };

#include "technique/eikonal/update.glsl"

#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform CheckPush {
    EikonalSweep sweep;
    float tolerance; // cells times index
    uint padding0;
} push;

void main() {
    EikonalGrid grid = volumes[push.sweep.volume].grid;
    uint index = linear_index();
    if (index >= grid.cells.x * grid.cells.y * grid.cells.z) return;
    uint column = index % (grid.cells.x * grid.cells.y);
    ivec3 at = ivec3(column % grid.cells.x, column / grid.cells.x, index / (grid.cells.x * grid.cells.y));
    int cell = cell_index(grid, at);
    uint known = values[cell];
    if (known == floatBitsToUint(OUTSIDE)) return;
    if ((known & GIVEN) != 0u) return;
    float value = uintBitsToFloat(known);
    if (value >= UNKNOWN) {
        atomicAdd(checks.unreached, 1u);
        return;
    }
    float off = abs(updated(push.sweep, grid, at, cell) - value) / (grid.index * grid.cell);
    if (floatBitsToUint(off) > checks.worst) atomicMax(checks.worst, floatBitsToUint(off));
    if (!(off <= push.tolerance)) atomicAdd(checks.unsettled, 1u);
}
