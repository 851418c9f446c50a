// How a wave rises from cell to cell. The kernel that includes this declares the buffer `values` of floats; their
// marks are looked through.
#include "technique/eikonal/fold.glsl"

float wave_at(EikonalGrid grid, ivec3 at) {
    bool there = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, ivec3(grid.cells)));
    return there ? abs(values[cell_index(grid, at)]) : UNKNOWN;
}

// Of fourth order from cells that are all known; beside a fold of second from the side that is smooth.
float rise_of(float far_below, float below, float here, float above, float far_above, float step) {
    float both = 0.5 * (above - below);
    vec3 bend = vec3(far_below - 2.0 * below + here, below - 2.0 * here + above, here - 2.0 * above + far_above);
    vec3 size = abs(bend);
    float least = min(min(size.x, size.y), size.z);
    if (!is_fold(least, max(max(size.x, size.y), size.z), step)) return both - (bend.z - bend.x) / 12.0;
    if (size.y <= least) return both;
    return size.x < size.z ? here - below + 0.5 * bend.x : above - here - 0.5 * bend.z;
}

// Where cells are missing, of second order from the sides that are there.
float rise_along(EikonalGrid grid, ivec3 at, ivec3 step, float here) {
    float below = wave_at(grid, at - step);
    float above = wave_at(grid, at + step);
    if (below >= UNKNOWN && above >= UNKNOWN) return 0.0;
    float far_below = below < UNKNOWN ? wave_at(grid, at - 2 * step) : UNKNOWN;
    float far_above = above < UNKNOWN ? wave_at(grid, at + 2 * step) : UNKNOWN;
    if (below >= UNKNOWN) return far_above < UNKNOWN ? 2.0 * above - 1.5 * here - 0.5 * far_above : above - here;
    if (above >= UNKNOWN) return far_below < UNKNOWN ? 1.5 * here - 2.0 * below + 0.5 * far_below : here - below;
    if (far_below >= UNKNOWN || far_above >= UNKNOWN) return 0.5 * (above - below);
    return rise_of(far_below, below, here, above, far_above, grid.index * grid.cell);
}

// A cell's, in columns and planes, m times index a cell.
vec3 rise_at_cell(EikonalGrid grid, ivec3 at, float here) {
    // Most cells have all neighbours, and need not ask for each.
    if (all(greaterThan(at, ivec3(1))) && all(lessThan(at, ivec3(grid.cells) - 2))) {
        int cell = cell_index(grid, at);
        ivec3 s = grid.strides;
        vec4 u = abs(vec4(values[cell - 2 * s.x], values[cell - s.x], values[cell + s.x], values[cell + 2 * s.x]));
        vec4 v = abs(vec4(values[cell - 2 * s.y], values[cell - s.y], values[cell + s.y], values[cell + 2 * s.y]));
        vec4 w = abs(vec4(values[cell - 2 * s.z], values[cell - s.z], values[cell + s.z], values[cell + 2 * s.z]));
        vec4 most = max(max(u, v), w);
        if (max(max(most.x, most.y), max(most.z, most.w)) < UNKNOWN) {
            float step = grid.index * grid.cell;
            return vec3(rise_of(u.x, u.y, here, u.z, u.w, step), rise_of(v.x, v.y, here, v.z, v.w, step),
                        rise_of(w.x, w.y, here, w.z, w.w, step));
        }
    }
    return vec3(rise_along(grid, at, ivec3(1, 0, 0), here), rise_along(grid, at, ivec3(0, 1, 0), here),
                rise_along(grid, at, ivec3(0, 0, 1), here));
}
