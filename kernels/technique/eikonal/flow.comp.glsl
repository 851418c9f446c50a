// One turn of a sweep of light along the wave (erratum 16): what comes into a cell through its faces goes out of it again,
// div(I grad phi) = 0, each face carrying what its upwind cell has. No light is lost or made, whatever the wave does. Turns go
// as those of the wave: outward from the foot, or one way across, then only blocks whose neighbours have changed.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 5, std430) buffer EikonalAsked { uint asked[]; };
layout(set = 3, binding = 6, std430) buffer EikonalLights { float lights[]; };

#include "technique/eikonal/grid.glsl"
#include "technique/eikonal/blocks.glsl"
#include "technique/eikonal/ask.glsl"

layout(push_constant) uniform FlowPush {
    EikonalSweep sweep;
    float least; // part of a cell's light: changes that are passed on
    uint outward;
} push;

// Of the way through a cell, the least that light leaves it by: where waves meet more comes in than goes out.
const float LEAST_OUT = 0.02;

float value_at(int cell, bool there) {
    return there ? abs(uintBitsToFloat(values[cell])) : UNKNOWN;
}

// What comes in and what goes out along an axis. A side that lacks a neighbour passes what it would if the wave went on bent as
// it is, and light likewise.
void along(inout float comes, inout float leaves, int cell, int stride, int place, int last, float here) {
    float below = value_at(cell - stride, place > 0);
    float above = value_at(cell + stride, place < last);
    bool has_below = below < UNKNOWN;
    bool has_above = above < UNKNOWN;
    if (!has_below && !has_above) return;
    float to_here = here - below;
    float from_here = above - here;
    if (!has_above) {
        float behind = value_at(cell - 2 * stride, place > 1);
        from_here = behind < UNKNOWN ? 2.0 * to_here - (below - behind) : to_here;
    }
    if (!has_below) {
        float behind = value_at(cell + 2 * stride, place < last - 1);
        to_here = behind < UNKNOWN ? 2.0 * from_here - (behind - above) : from_here;
    }
    leaves += max(from_here, 0.0) + max(-to_here, 0.0);
    if (has_below) comes += max(to_here, 0.0) * lights[cell - stride];
    else leaves -= max(to_here, 0.0);
    if (has_above) comes += max(-from_here, 0.0) * lights[cell + stride];
    else leaves -= max(-from_here, 0.0);
}

// The largest change over what is there.
float visit(EikonalSweep sweep, ivec2 column, int block) {
    int plane = block * BLOCK;
    int end = min(plane + BLOCK, int(sweep.cells.z));
    int cell = sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + plane * sweep.strides.z;
    float change = 0.0;
    ivec3 last = ivec3(sweep.cells) - 1;
    for (; plane < end; plane++) {
        uint known = values[cell];
        float here = uintBitsToFloat(known);
        if ((known & GIVEN) == 0u && here < UNKNOWN) {
            float comes = 0.0;
            float leaves = 0.0;
            along(comes, leaves, cell, sweep.strides.x, column.x, last.x, here);
            along(comes, leaves, cell, sweep.strides.y, column.y, last.y, here);
            along(comes, leaves, cell, sweep.strides.z, plane, last.z, here);
            float light = comes / max(leaves, LEAST_OUT * sweep.step);
            change = max(change, abs(light - lights[cell]) / max(light, 1e-20));
            lights[cell] = light;
        }
        cell += sweep.strides.z;
    }
    return change;
}

void main() {
    EikonalSweep sweep = push.sweep;
    ivec2 column;
    int block;
    if (push.outward != 0u) {
        if (outward_block(sweep, linear_index(), column, block)) visit(sweep, column, block);
        return;
    }
    if (!one_way_block(sweep, linear_index(), column, block)) return;
    int here = asked_index(sweep, column, block);
    if (asked[here] == 0u) return;
    asked[here] = 0u;
    if (visit(sweep, column, block) > push.least) ask_around(sweep, column, block, here);
}
