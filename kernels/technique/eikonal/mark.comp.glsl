// Which cells are so near the surface that their values are to be given: at most `band` cells below it along one of the axes. A
// column an invocation.
#include "shared/index.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 3, std430) readonly buffer EikonalTops { int tops[]; };
layout(push_constant) uniform EikonalPush {
    uint volume;
} push;

void main() {
    EikonalVolume volume = volumes[push.volume];
    EikonalGrid grid = volume.grid;
    uint column = linear_index();
    ivec2 columns = ivec2(grid.cells.xy);
    if (column >= grid.cells.x * grid.cells.y) return;
    ivec2 at = ivec2(column % grid.cells.x, column / grid.cells.x);
    int top = tops[column];
    int end = top + int(volume.band);
    for (int away = 1; away <= int(volume.band); away++) {
        if (at.x >= away) end = max(end, tops[column - away]);
        if (at.x < columns.x - away) end = max(end, tops[column + away]);
        if (at.y >= away) end = max(end, tops[column - away * columns.x]);
        if (at.y < columns.y - away) end = max(end, tops[column + away * columns.x]);
    }
    for (int plane = top; plane < min(end, int(grid.cells.z)); plane++) {
        int cell = cell_index(grid, ivec3(at, plane));
        if (values[cell] == floatBitsToUint(UNKNOWN)) values[cell] = floatBitsToUint(WANTED);
    }
}
