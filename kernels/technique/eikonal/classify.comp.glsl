// Which cells the wave goes through, from how often each column has gone in and out: a column an invocation.
#include "shared/index.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(push_constant) uniform VolumePush {
    uint volume;
} push;

void main() {
    EikonalGrid grid = volumes[push.volume].grid;
    uint column = linear_index();
    if (column >= grid.cells.x * grid.cells.y) return;
    int inside = 0;
    ivec3 at = ivec3(column % grid.cells.x, column / grid.cells.x, 0);
    for (; at.z < int(grid.cells.z); at.z++) {
        int cell = cell_index(grid, at);
        inside += int(values[cell]);
        values[cell] = floatBitsToUint(inside > 0 ? UNKNOWN : OUTSIDE);
    }
}
