// How much the wave rises inwards from the grid's sides, a cell, where it is given: a line of cells along the light's way an
// invocation.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) writeonly buffer EikonalSides { float sides[]; };

#include "technique/eikonal/volume.glsl"
#include "technique/eikonal/sides.glsl"
#include "technique/eikonal/values.glsl"

layout(push_constant) uniform EikonalPush {
    uint volume;
} push;

void main() {
    EikonalGrid grid = volumes[push.volume].grid;
    uint line = linear_index();
    ivec2 last = ivec2(grid.cells.xy) - 1;
    if (line >= 2u * (grid.cells.x + grid.cells.y)) return;
    bool across_u = line < 2u * grid.cells.y;
    uint place = across_u ? line : line - 2u * grid.cells.y;
    uint length = across_u ? grid.cells.y : grid.cells.x;
    bool far = place >= length;
    int along = int(far ? place - length : place);
    ivec3 at = across_u ? ivec3(far ? last.x : 0, along, 0) : ivec3(along, far ? last.y : 0, 0);
    int inwards = (across_u ? grid.strides.x : grid.strides.y) * (far ? -1 : 1);
    int deep = across_u ? last.x : last.y;
    float rise = 0.0;
    for (; at.z < int(grid.cells.z); at.z++) {
        int cell = cell_index(grid, at);
        if (deep >= 1 && given(cell) && given(cell + inwards)) {
            rise = value_at(cell + inwards) - value_at(cell);
            // At the side's middle, not half a cell inwards.
            if (deep >= 2 && given(cell + 2 * inwards)) {
                rise = 1.5 * rise - 0.5 * (value_at(cell + 2 * inwards) - value_at(cell + inwards));
            }
        }
        sides[across_u ? side_u(grid.cells, at) : side_v(grid.cells, at)] = given(cell) ? rise : 0.0;
    }
}
