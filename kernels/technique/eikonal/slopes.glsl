// How a wave rises from cell to cell. The kernel that includes this declares the buffer `values`, without marks.

float wave_at(EikonalGrid grid, ivec3 at) {
    bool there = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, ivec3(grid.cells)));
    return there ? values[cell_index(grid, at)] : UNKNOWN;
}

// Of second order from both sides, or from one where the other is not known.
float rise_along(EikonalGrid grid, ivec3 at, ivec3 step, float here) {
    float below = wave_at(grid, at - step);
    float above = wave_at(grid, at + step);
    if (below < UNKNOWN && above < UNKNOWN) return 0.5 * (above - below);
    if (below >= UNKNOWN && above >= UNKNOWN) return 0.0;
    float side = above < UNKNOWN ? 1.0 : -1.0;
    float near = above < UNKNOWN ? above : below;
    float far = wave_at(grid, at + 2 * int(side) * step);
    return side * (far < UNKNOWN ? 2.0 * near - 1.5 * here - 0.5 * far : near - here);
}

// A cell's, in columns and planes, m times index a cell.
vec3 rise_at_cell(EikonalGrid grid, ivec3 at, float here) {
    return vec3(rise_along(grid, at, ivec3(1, 0, 0), here), rise_along(grid, at, ivec3(0, 1, 0), here),
                rise_along(grid, at, ivec3(0, 0, 1), here));
}
