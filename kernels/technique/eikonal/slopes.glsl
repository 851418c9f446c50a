// How a wave rises from cell to cell. The kernel that includes this declares the buffer `values` of floats; their
// marks are looked through.
#include "technique/eikonal/fold.glsl"

float wave_at(EikonalGrid grid, ivec3 at) {
    bool there = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, ivec3(grid.cells)));
    return there ? abs(values[cell_index(grid, at)]) : UNKNOWN;
}

// Of fourth order; beside a fold and where cells are missing, of second from the side that is smooth.
float rise_along(EikonalGrid grid, ivec3 at, ivec3 step, float here) {
    float below = wave_at(grid, at - step);
    float above = wave_at(grid, at + step);
    if (below >= UNKNOWN && above >= UNKNOWN) return 0.0;
    float far_below = below < UNKNOWN ? wave_at(grid, at - 2 * step) : UNKNOWN;
    float far_above = above < UNKNOWN ? wave_at(grid, at + 2 * step) : UNKNOWN;
    if (below >= UNKNOWN) return far_above < UNKNOWN ? 2.0 * above - 1.5 * here - 0.5 * far_above : above - here;
    if (above >= UNKNOWN) return far_below < UNKNOWN ? 1.5 * here - 2.0 * below + 0.5 * far_below : here - below;
    float both = 0.5 * (above - below);
    if (far_below >= UNKNOWN || far_above >= UNKNOWN) return both;
    vec3 bend = vec3(far_below - 2.0 * below + here, below - 2.0 * here + above, here - 2.0 * above + far_above);
    vec3 size = abs(bend);
    float least = min(min(size.x, size.y), size.z);
    if (!is_fold(least, max(max(size.x, size.y), size.z), grid.index * grid.cell)) return both - (bend.z - bend.x) / 12.0;
    if (size.y <= least) return both;
    return size.x < size.z ? here - below + 0.5 * bend.x : above - here - 0.5 * bend.z;
}

// A cell's, in columns and planes, m times index a cell.
vec3 rise_at_cell(EikonalGrid grid, ivec3 at, float here) {
    return vec3(rise_along(grid, at, ivec3(1, 0, 0), here), rise_along(grid, at, ivec3(0, 1, 0), here),
                rise_along(grid, at, ivec3(0, 0, 1), here));
}
