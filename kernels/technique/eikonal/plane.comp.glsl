// One plane of a wave from the plane before it: light in one medium is straight, so that the value in a cell is the least, over
// places in the plane before, of what is there and the way from it. Places between cells are cubic in each direction, which
// leaves less error than differences do and none where light turns from one neighbour to another. A column an invocation.
#include "shared/index.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 4, std430) buffer EikonalSides { float sides[]; };

#include "technique/eikonal/grid.glsl"
#include "technique/eikonal/blocks.glsl"
#include "technique/eikonal/fold.glsl"
#include "technique/eikonal/sides.glsl"
#include "technique/eikonal/values.glsl"

layout(push_constant) uniform SweepPush {
    EikonalSweep sweep; // its turn is the plane
} push;

// Places that are tried for a cell, each from the slope at the one before: what is left falls by about the part that a cell is
// of the way to the focus, and the value does not change to the first order.
const int ROUNDS = 2;

float before_at(int cell) {
    return min(value_at(cell), UNKNOWN);
}

float before_at(ivec2 column) {
    EikonalSweep sweep = push.sweep;
    return before_at(sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + (int(sweep.turn) - 1) * sweep.strides.z);
}

// One cell beyond the grid's sides the wave goes on as bent as it is there: only for what lies between cells that are there.
float bent_before_at(ivec2 column) {
    ivec2 last = ivec2(push.sweep.cells.xy) - 1;
    ivec2 nearest = clamp(column, ivec2(0), last);
    float value = before_at(nearest);
    if (nearest == column || value >= UNKNOWN) return value;
    for (int axis = 0; axis < 2; axis++) {
        int beyond = column[axis] - nearest[axis];
        if (beyond == 0 || last[axis] < 2) continue;
        ivec2 near = nearest;
        ivec2 far = nearest;
        near[axis] -= beyond;
        far[axis] -= 2 * beyond;
        float rise = before_at(nearest) - before_at(near);
        value += 2.0 * rise - (before_at(near) - before_at(far));
    }
    return value < 0.5 * UNKNOWN ? value : UNKNOWN;
}

// Value and slope between the middle two of four in a row, `part` of the way.
vec2 between(vec4 f, float part) {
    vec2 bend = vec2(f.x - 2.0 * f.y + f.z, f.y - 2.0 * f.z + f.w);
    vec2 size = abs(bend);
    if (is_fold(min(size.x, size.y), max(size.x, size.y), push.sweep.step)) bend = vec2(size.x < size.y ? bend.x : bend.y);
    float near = ((2.0 - part) * bend.x + (1.0 + part) * bend.y) / 3.0;
    float turn = (bend.y - bend.x) / 3.0;
    float value = f.y + part * (f.z - f.y) + 0.5 * part * (part - 1.0) * near;
    return vec2(value, f.z - f.y + (part - 0.5) * near + 0.5 * part * (part - 1.0) * turn);
}

// Four cells in a row along u.
vec4 row_before(ivec2 first) {
    EikonalSweep sweep = push.sweep;
    if (first.x >= 0 && first.y >= 0 && first.x + 3 < int(sweep.cells.x) && first.y < int(sweep.cells.y)) {
        int cell = sweep.first + first.x * sweep.strides.x + first.y * sweep.strides.y + (int(sweep.turn) - 1) * sweep.strides.z;
        return vec4(before_at(cell), before_at(cell + sweep.strides.x), before_at(cell + 2 * sweep.strides.x),
                    before_at(cell + 3 * sweep.strides.x));
    }
    return vec4(bent_before_at(first), bent_before_at(first + ivec2(1, 0)), bent_before_at(first + ivec2(2, 0)),
                bent_before_at(first + ivec2(3, 0)));
}

float most_of(vec4 a) {
    return max(max(a.x, a.y), max(a.z, a.w));
}

// How much the wave rises inwards, a cell, at a place in one of the grid's sides in the plane before: what it was where this part of
// the wave came from, not what it is inside, which would grow on itself. `axis`: across the side.
float rise_before(vec2 place, int axis) {
    int along = 1 - axis;
    ivec2 low = ivec2(round(place));
    low[along] = int(floor(place[along]));
    ivec2 high = low;
    high[along] = min(low[along] + 1, int(push.sweep.cells[along]) - 1);
    bool low_known = before_at(low) < UNKNOWN;
    bool high_known = before_at(high) < UNKNOWN;
    int plane = int(push.sweep.turn) - 1;
    uvec3 cells = push.sweep.cells;
    float at_low = sides[axis == 0 ? side_u(cells, ivec3(low, plane)) : side_v(cells, ivec3(low, plane))];
    float at_high = sides[axis == 0 ? side_u(cells, ivec3(high, plane)) : side_v(cells, ivec3(high, plane))];
    if (low_known && high_known) return mix(at_low, at_high, place[along] - float(low[along]));
    return low_known ? at_low : high_known ? at_high : 0.0;
}

// From a place in a side to what lies beyond it: value and slopes.
vec3 beyond_sides(float value, vec2 slope, vec2 place, vec2 beyond) {
    if (beyond.x != 0.0) slope.x = -sign(beyond.x) * rise_before(place, 0);
    if (beyond.y != 0.0) slope.y = -sign(beyond.y) * rise_before(place, 1);
    return vec3(value + dot(slope, beyond), slope);
}

// Value and slopes along u and v at a place in the plane before; UNKNOWN where cells around it are. Beyond the grid's sides the
// wave goes on straight, or is unknown. Written out row by row: llvmpipe takes long over indexed vectors.
vec3 wave_before(vec2 wanted) {
    vec2 last = vec2(push.sweep.cells.xy) - 1.0;
    vec2 place = clamp(wanted, vec2(0.0), last);
    vec2 beyond = wanted - place;
    if (beyond != vec2(0.0) && (push.sweep.options & SWEEP_LINEAR) == 0u) return vec3(UNKNOWN, 0.0, 0.0);
    vec2 low = min(floor(place), max(last - 1.0, vec2(0.0)));
    vec2 part = place - low;
    ivec2 first = ivec2(low) - 1;
    vec4 a = row_before(first);
    vec4 b = row_before(first + ivec2(0, 1));
    vec4 c = row_before(first + ivec2(0, 2));
    vec4 d = row_before(first + ivec2(0, 3));
    if (max(most_of(max(a, b)), most_of(max(c, d))) < UNKNOWN) {
        vec2 on_b = between(b, part.x);
        vec2 on_c = between(c, part.x);
        vec2 along = between(vec4(between(a, part.x).x, on_b.x, on_c.x, between(d, part.x).x), part.y);
        return beyond_sides(along.x, vec2(mix(on_b.y, on_c.y, part.y), along.y), place, beyond);
    }
    vec4 corner = vec4(b.yz, c.yz);
    if (most_of(corner) >= UNKNOWN) return vec3(UNKNOWN, 0.0, 0.0);
    vec2 rows = mix(corner.xz, corner.yw, part.x);
    vec2 slope = vec2(mix(corner.y - corner.x, corner.w - corner.z, part.y), rows.y - rows.x);
    return beyond_sides(mix(rows.x, rows.y, part.y), slope, place, beyond);
}

// From a cell back to the plane before, in cells, along a wave of that slope.
vec2 way_back(vec2 slope) {
    float whole = push.sweep.step * push.sweep.step;
    return slope * inversesqrt(max(whole - dot(slope, slope), 0.04 * whole));
}

float way(vec2 across) {
    return push.sweep.step * sqrt(1.0 + dot(across, across));
}

void main() {
    EikonalSweep sweep = push.sweep;
    uint index = linear_index();
    if (index >= sweep.cells.x * sweep.cells.y) return;
    ivec2 column = column_of(index, sweep.cells.x);
    int cell = sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + int(sweep.turn) * sweep.strides.z;
    if (!open_cell(values[cell])) return;

    ivec2 last = ivec2(sweep.cells.xy) - 1;
    // Where the plane before says that light comes from, unless it comes from a cell further off than those around.
    vec4 u = row_before(column + ivec2(-1, 0));
    vec2 v = vec2(bent_before_at(column - ivec2(0, 1)), bent_before_at(column + ivec2(0, 1)));
    bool smooth_here = max(most_of(vec4(u.xz, v)), u.y) < UNKNOWN;
    vec2 from = vec2(column);
    if (smooth_here) from -= clamp(way_back(0.5 * vec2(u.z - u.x, v.y - v.x)), -8.0, 8.0);
    ivec2 nearest = clamp(ivec2(round(from)), min(ivec2(1), last), max(last - 1, ivec2(0)));
    vec4 a = row_before(nearest + ivec2(-1, -1));
    vec4 b = row_before(nearest + ivec2(-1, 0));
    vec4 c = row_before(nearest + ivec2(-1, 1));
    vec2 off = vec2(column - nearest);
    vec3 below = vec3(a.x + way(off + vec2(1.0, 1.0)), a.y + way(off + vec2(0.0, 1.0)), a.z + way(off + vec2(-1.0, 1.0)));
    vec3 level = vec3(b.x + way(off + vec2(1.0, 0.0)), b.y + way(off), b.z + way(off + vec2(-1.0, 0.0)));
    vec3 over = vec3(c.x + way(off + vec2(1.0, -1.0)), c.y + way(off + vec2(0.0, -1.0)), c.z + way(off - vec2(1.0, 1.0)));
    vec3 least = min(min(below, level), over);
    float best = min(min(least.x, least.y), least.z);
    if (best < level.y || !smooth_here) {
        from = vec2(nearest);
        from.x += least.y <= best ? 0.0 : least.x <= best ? -1.0 : 1.0;
        vec3 low = vec3(min(min(below.x, below.y), below.z), min(min(level.x, level.y), level.z), 0.0);
        from.y += low.y <= best ? 0.0 : low.x <= best ? -1.0 : 1.0;
    }
    for (int i = 0; i < ROUNDS; i++) {
        vec3 there = wave_before(from);
        if (there.x >= UNKNOWN) break;
        best = min(best, there.x + way(vec2(column) - from));
        from = vec2(column) - clamp(way_back(there.yz), -8.0, 8.0);
    }
    values[cell] = floatBitsToUint(min(best, UNKNOWN));
    ivec3 at = ivec3(column, int(sweep.turn));
    vec2 came = clamp(from, vec2(0.0), vec2(last));
    if (column.x == 0 || column.x == last.x) sides[side_u(sweep.cells, at)] = rise_before(vec2(column.x, came.y), 0);
    if (column.y == 0 || column.y == last.y) sides[side_v(sweep.cells, at)] = rise_before(vec2(came.x, column.y), 1);
}
