// One turn of a further sweep, along the light's way and one way across it along each axis. Light is straight, so that each
// bit of it goes the way of one of four such sweeps. Only columns that the last check asked for.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) buffer EikonalSides { float sides[]; };

#include "technique/eikonal/update.glsl"
#include "technique/eikonal/block.glsl"
#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform SweepPush {
    EikonalSweep sweep;
} push;

void main() {
    EikonalSweep sweep = push.sweep;
    uint index = linear_index();
    if (index >= checks.size_u * checks.size_v) return;
    ivec2 size = ivec2(checks.size_u, checks.size_v);
    ivec2 off = column_of(index, checks.size_u);
    ivec2 column = ivec2(checks.lower_u, checks.lower_v) + off;
    if ((sweep.options & SWEEP_BACKWARD_U) != 0u) off.x = size.x - 1 - off.x;
    if ((sweep.options & SWEEP_BACKWARD_V) != 0u) off.y = size.y - 1 - off.y;
    int block = int(sweep.turn) - off.x - off.y;
    if (block < 0 || block * BLOCK >= int(sweep.cells.z)) return;
    visit(sweep, column, block);
}
