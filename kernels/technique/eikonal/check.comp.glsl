// How far cells are from what their neighbours say: a block of planes in a column an invocation.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) readonly buffer EikonalSides { float sides[]; };
layout(set = 3, binding = 5, std430) writeonly buffer EikonalAsked { uint asked[]; }; // blocks that are to be visited again

#include "technique/eikonal/update.glsl"
#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform CheckPush {
    EikonalSweep sweep;
    float tolerance; // cells times index
    float asks;      // cells times index: from which on a block is visited again
} push;

void main() {
    EikonalSweep sweep = push.sweep;
    int blocks = (int(sweep.cells.z) + BLOCK - 1) / BLOCK;
    uint index = linear_index();
    if (index >= sweep.cells.x * sweep.cells.y * uint(blocks)) return;
    ivec2 column = column_of(index, sweep.cells.x);
    int block = int((float(column.y) + 0.5) / float(sweep.cells.y));
    column.y -= block * int(sweep.cells.y);
    BlockWalk walk = walk_block(sweep, column, block);
    uint unsettled = 0u;
    uint unreached = 0u;
    float worst = 0.0;
    while (walk.plane < walk.end) {
        uint known = values[walk.cell];
        float value = abs(uintBitsToFloat(known));
        if (open_cell(known)) {
            float off = abs(updated(sweep, ivec3(column, walk.plane), walk.cell, walk.before).value - value) / sweep.step;
            worst = max(worst, off);
            if (value >= UNKNOWN) unreached++;
            if (!(off <= push.tolerance)) unsettled++;
        }
        step_on(sweep, walk, value);
    }
    bool again = worst > push.asks;
    asked[index] = again ? 1u : 0u;
    if (again) atomicAdd(checks.asked, 1u);
    // Few get here, so that they seldom wait for each other.
    if (again) atomicMax(checks.worst, floatBitsToUint(worst));
    if (unsettled > 0u) atomicAdd(checks.unsettled, unsettled);
    if (unreached > 0u) atomicAdd(checks.unreached, unreached);
}
