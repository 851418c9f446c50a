// One cell's value from its neighbours. The kernel that includes this declares the buffer `values`.
#include "technique/eikonal/volume.glsl"
#include "technique/eikonal/godunov.glsl"

struct EikonalSweep {
    uint volume;
    uint order;     // 1 or 2
    uint linear;    // 1: at the grid's sides that waves come in by, they go on as they are inside
    uint visits;    // of each cell
    ivec2 foot;     // the column under the light
    uint turn;
    uint inward;    // bits 0 and 1: along u and v cells are visited towards the foot, else outward from it
};

// Levels from one visit of a cell to its next: what is at work at the same time is never within two cells of each other.
const int SPACING = 3;

float value_at(int cell) {
    return abs(uintBitsToFloat(values[cell]));
}

// How much the wave rises along an axis inwards from a side that it comes in by, a cell: as in the plane before where that is
// given, else two planes before. Places one plane before are at work at the same time as the cell.
float rise_inwards(EikonalGrid grid, int cell, int inwards) {
    int before = cell - grid.strides.z;
    if ((values[before] & values[before + inwards] & GIVEN) == 0u) before -= grid.strides.z;
    float here = value_at(before);
    float there = value_at(before + inwards);
    return here < UNKNOWN && there < UNKNOWN ? max(there - here, 0.0) : 0.0;
}

float updated(EikonalSweep sweep, EikonalGrid grid, ivec3 at, int cell) {
    vec3 value = vec3(UNKNOWN);
    vec3 weight = vec3(1.0);
    float step = grid.index * grid.cell;
    float square = step * step;
    for (int axis = 0; axis < 3; axis++) {
        int stride = grid.strides[axis];
        int last = int(grid.cells[axis]) - 1;
        int place = at[axis];
        float below = place > 0 ? value_at(cell - stride) : UNKNOWN;
        float above = place < last ? value_at(cell + stride) : UNKNOWN;
        bool up = below <= above;
        value[axis] = min(below, above);
        if (sweep.order == 2u && value[axis] < UNKNOWN) {
            int way = up ? -1 : 1;
            int end = place + 2 * way;
            bool there = end >= 0 && end <= last;
            // Across the foot two cells are visited at once; there the first order does.
            if (axis < 2) there = there && abs(end - sweep.foot[axis]) != abs(place - sweep.foot[axis]);
            if (there) {
                float far = value_at(cell + 2 * way * stride);
                if (far <= value[axis]) {
                    value[axis] = (4.0 * value[axis] - far) / 3.0;
                    weight[axis] = 2.25;
                }
            }
        }
        if (axis == 2 || sweep.linear == 0u || at.z < 2 || last < 1 || place != sweep.foot[axis]) continue;
        if (place != 0 && place != last) continue;
        float rise = rise_inwards(grid, cell, place == 0 ? stride : -stride);
        if (rise > 0.0) {
            value[axis] = UNKNOWN;
            square -= rise * rise;
        }
    }
    return upwind(value, weight, max(square, 0.01 * step * step));
}
