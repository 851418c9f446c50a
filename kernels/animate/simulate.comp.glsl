// One step of h_tt + damping h_t = speed^2 (h_xx + h_zz) by leapfrog, one invocation a vertex: the step's increment is
// kept beside the height, h(n+1) = h(n) + d(n+1/2). Damping acts on the mean of two increments, which is stable for any;
// steps are short enough that it takes only part of an increment.
#include "shared/index.glsl"
#include "animate/sheet.glsl"

layout(set = 0, binding = 0, std430) readonly buffer HeightsNow { vec2 now[]; };
layout(set = 0, binding = 1, std430) writeonly buffer HeightsNext { vec2 next[]; };
layout(set = 0, binding = 2, std430) buffer Increments { vec2 increments[]; };
layout(push_constant) uniform SimulatePush { SheetPush push; };

vec2 from(vec2 there, vec2 here, float along) {
    precise float gain = push.gain * (along * difference(there, here));
    return vec2(gain, 0.0);
}

void main() {
    uint index = linear_index();
    if (index >= push.columns * push.rows) return;
    uint column = index % push.columns;
    uint row = index / push.columns;
    uvec2 x = neighbours(column, push.columns);
    uvec2 z = neighbours(row, push.rows);
    uint at = row * push.columns;
    vec2 here = now[index];
    // What one vertex gains its neighbour loses, to the last bit: the mean height stays. Neighbours change places in
    // commuting sums alone: a sheet that starts symmetric stays so.
    vec2 across = add(from(now[at + x.x], here, push.along_x), from(now[at + x.y], here, push.along_x));
    vec2 along = add(
        from(now[z.x * push.columns + column], here, push.along_z),
        from(now[z.y * push.columns + column], here, push.along_z)
    );
    vec2 increment = increments[index];
    precise float loss = push.loss * increment.x;
    increment = add(add(increment, vec2(-loss, 0.0)), add(across, along));
    increments[index] = increment;
    next[index] = add(here, increment);
}
