// One turn of a further sweep, along the light's way and one way across it along each axis. Light is straight, so that each
// bit of it goes the way of one of four such sweeps. Only blocks that the last check asked for are visited, and those next to
// what has changed since.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) buffer EikonalSides { float sides[]; };
layout(set = 3, binding = 5, std430) buffer EikonalAsked { uint asked[]; };

#include "technique/eikonal/update.glsl"
#include "technique/eikonal/block.glsl"
#include "technique/eikonal/ask.glsl"

layout(push_constant) uniform SettlePush {
    EikonalSweep sweep;
    float least; // changes that are passed on, m times index
    uint padding0;
} push;

void main() {
    EikonalSweep sweep = push.sweep;
    ivec2 column;
    int block;
    if (!one_way_block(sweep, linear_index(), column, block)) return;
    int here = asked_index(sweep, column, block);
    if (asked[here] == 0u) return;
    asked[here] = 0u;
    if (visit(sweep, column, block) > push.least) ask_around(sweep, column, block, here);
}
