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
    int plane = block * BLOCK;
    int end = min(plane + BLOCK, int(sweep.cells.z));
    int cell = sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + plane * sweep.strides.z;
    vec2 before = vec2(UNKNOWN);
    if (plane > 0) before.x = value_at(cell - sweep.strides.z);
    if (plane > 1) before.y = value_at(cell - 2 * sweep.strides.z);
    uint unsettled = 0u;
    uint unreached = 0u;
    float worst = 0.0;
    for (; plane < end; plane++) {
        uint known = values[cell];
        float value = abs(uintBitsToFloat(known));
        if ((known & GIVEN) == 0u && known != floatBitsToUint(OUTSIDE)) {
            float off = abs(updated(sweep, ivec3(column, plane), cell, before).value - value) / sweep.step;
            worst = max(worst, off);
            if (value >= UNKNOWN) unreached++;
            if (!(off <= push.tolerance)) unsettled++;
        }
        before = vec2(value, before.x);
        cell += sweep.strides.z;
    }
    bool again = worst > push.asks;
    asked[index] = again ? 1u : 0u;
    if (again) atomicAdd(checks.asked, 1u);
    // Few get here, so that they seldom wait for each other.
    if (again) atomicMax(checks.worst, floatBitsToUint(worst));
    if (unsettled > 0u) atomicAdd(checks.unsettled, unsettled);
    if (unreached > 0u) atomicAdd(checks.unreached, unreached);
}
