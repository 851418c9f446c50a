// A cell's value from its neighbours. The kernel that includes this declares the buffers `values` and `sides`.
#include "technique/eikonal/grid.glsl"
#include "technique/eikonal/godunov.glsl"
#include "technique/eikonal/sides.glsl"
#include "technique/eikonal/blocks.glsl"
#include "technique/eikonal/values.glsl"

// The cells of a block in a column, one after the other.
struct BlockWalk {
    int plane;
    int end;
    int cell;
    vec2 before; // values one and two planes before
};

BlockWalk walk_block(EikonalSweep sweep, ivec2 column, int block) {
    BlockWalk walk;
    walk.plane = block * BLOCK;
    walk.end = min(walk.plane + BLOCK, int(sweep.cells.z));
    walk.cell = sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + walk.plane * sweep.strides.z;
    walk.before = vec2(UNKNOWN);
    if (walk.plane > 0) walk.before.x = value_at(walk.cell - sweep.strides.z);
    if (walk.plane > 1) walk.before.y = value_at(walk.cell - 2 * sweep.strides.z);
    return walk;
}

// `value`: what the cell has now.
void step_on(EikonalSweep sweep, inout BlockWalk walk, float value) {
    walk.before = vec2(value, walk.before.x);
    walk.cell += sweep.strides.z;
    walk.plane++;
}

// Along an axis: an upwind neighbour, which side it is on, and what it counts for.
struct Upwind {
    float near;
    int way;
    vec2 term;
};

Upwind across(bool second, int cell, int stride, int place, int last) {
    float below = place > 0 ? value_at(cell - stride) : UNKNOWN;
    float above = place < last ? value_at(cell + stride) : UNKNOWN;
    Upwind a;
    a.way = below <= above ? -1 : 1;
    a.near = min(below, above);
    a.term = vec2(a.near, 1.0);
    int end = place + 2 * a.way;
    if (second && end >= 0 && end <= last && a.near < UNKNOWN) a.term = upwind_term(a.near, value_at(cell + 2 * a.way * stride));
    return a;
}

// How much the wave rises inwards from a side, a cell: what it was where this part of the wave came from, in the side itself.
// As in the paper's Algorithm 2 where it came from is told by a wave that goes as if the side were all there is.
float rise_at(float whole, uint here, uint line, vec2 along, float before, Upwind beside) {
    float reached = upwind(along, beside.term, vec2(UNKNOWN, 1.0), whole);
    vec2 part = vec2(before < UNKNOWN ? reached - before : 0.0, beside.near < UNKNOWN ? reached - beside.near : 0.0);
    part = max(part, vec2(0.0));
    vec2 rise = vec2(part.x > 0.0 ? sides[here - line] : 0.0, part.y > 0.0 ? sides[int(here) + beside.way] : 0.0);
    return part.x + part.y > 0.0 ? dot(part, rise) / (part.x + part.y) : 0.0;
}

struct Updated {
    float value;
    vec2 rise; // at sides across u and v
};

// `before`: the values one and two planes before. Light does not turn back, so along its way only those matter.
Updated updated(EikonalSweep sweep, ivec3 at, int cell, vec2 before) {
    bool second = (sweep.options & SWEEP_SECOND) != 0u;
    ivec2 last = ivec2(sweep.cells.xy) - 1;
    vec2 along = second ? upwind_term(before.x, before.y) : vec2(before.x, 1.0);
    Upwind u = across(second, cell, sweep.strides.x, at.x, last.x);
    Upwind v = across(second, cell, sweep.strides.y, at.y, last.y);
    float whole = sweep.step * sweep.step;
    float square = whole;
    Updated result;
    result.rise = vec2(0.0);
    bvec2 side = bvec2(at.x == 0 || at.x == last.x, at.y == 0 || at.y == last.y);
    if ((sweep.options & SWEEP_LINEAR) != 0u && any(side)) {
        if (side.x) result.rise.x = rise_at(whole, side_u(sweep.cells, at), sweep.cells.y, along, before.x, v);
        if (side.y) result.rise.y = rise_at(whole, side_v(sweep.cells, at), sweep.cells.x, along, before.x, u);
        if (result.rise.x > 0.0) u.term.x = UNKNOWN;
        if (result.rise.y > 0.0) v.term.x = UNKNOWN;
        vec2 inwards = max(result.rise, vec2(0.0));
        square -= dot(inwards, inwards);
    }
    result.value = upwind(along, u.term, v.term, max(square, 0.01 * whole));
    return result;
}
