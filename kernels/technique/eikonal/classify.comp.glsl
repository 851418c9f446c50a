// Which cells the wave goes through, from how often each column has gone in and out: a column an invocation.
#include "shared/index.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 3, std430) writeonly buffer EikonalTops { int tops[]; }; // each column's first plane inside
layout(push_constant) uniform EikonalPush {
    uint volume;
} push;

void main() {
    EikonalGrid grid = volumes[push.volume].grid;
    uint column = linear_index();
    if (column >= grid.cells.x * grid.cells.y) return;
    int cell = cell_index(grid, ivec3(column % grid.cells.x, column / grid.cells.x, 0));
    int inside = 0;
    int top = int(grid.cells.z);
    for (int plane = 0; plane < int(grid.cells.z); plane++) {
        inside += int(values[cell]);
        if (inside > 0) top = min(top, plane);
        values[cell] = floatBitsToUint(inside > 0 ? UNKNOWN : OUTSIDE);
        cell += grid.strides.z;
    }
    tops[column] = top;
}
