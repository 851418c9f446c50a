// What a volume says of a place between its cells. The kernel that includes this declares the buffers `values` (without marks)
// and `cell_lights`.

struct LookUp {
    vec3 way;    // unit, world space: where light goes
    float light; // as cell_lights has it; 0 where nothing is known
};

// Planes below a place that are looked at where it has the surface on all sides.
const int DEEPER = 2;
// Cells beside the grid that are taken for those at its sides.
const float BESIDE = 1.5;

float wave_at(EikonalGrid grid, ivec3 at) {
    bool there = all(greaterThanEqual(at, ivec3(0))) && all(lessThan(at, ivec3(grid.cells)));
    return there ? values[cell_index(grid, at)] : UNKNOWN;
}

// How much the wave rises from cell to cell along an axis, from both sides where they are known.
float rise_along(EikonalGrid grid, ivec3 at, ivec3 step, float here) {
    float below = wave_at(grid, at - step);
    float above = wave_at(grid, at + step);
    if (below < UNKNOWN && above < UNKNOWN) return 0.5 * (above - below);
    if (above < UNKNOWN) return above - here;
    return below < UNKNOWN ? here - below : 0.0;
}

// Trilinear over the cells around that the wave has reached.
bool look_up_at(EikonalGrid grid, vec3 at, out LookUp found) {
    vec3 low = floor(at);
    vec3 part = at - low;
    vec3 rise = vec3(0.0);
    float light = 0.0;
    float sum = 0.0;
    for (int corner = 0; corner < 8; corner++) {
        ivec3 bit = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
        ivec3 cell = ivec3(low) + bit;
        vec3 share = mix(1.0 - part, part, vec3(bit));
        float weight = share.x * share.y * share.z;
        float here = wave_at(grid, cell);
        if (weight <= 0.0 || !(here < UNKNOWN)) continue;
        sum += weight;
        light += weight * cell_lights[cell_index(grid, cell)];
        rise.x += weight * rise_along(grid, cell, ivec3(1, 0, 0), here);
        rise.y += weight * rise_along(grid, cell, ivec3(0, 1, 0), here);
        rise.z += weight * rise_along(grid, cell, ivec3(0, 0, 1), here);
    }
    float steep = length(rise);
    found = LookUp(turn_to_world(grid, rise / max(steep, 1e-20)), light / max(sum, 1e-20));
    return sum > 0.0 && steep > 0.0;
}

LookUp look_up(EikonalGrid grid, vec3 world) {
    LookUp found = LookUp(vec3(0.0), 0.0);
    vec3 at = to_cells(grid, world);
    vec3 last = vec3(grid.cells) - 1.0;
    vec3 inside = clamp(at, vec3(0.0), last);
    vec3 beside = abs(at - inside);
    if (max(max(beside.x, beside.y), beside.z) > BESIDE) return found;
    for (int i = 0; i <= DEEPER; i++) {
        if (look_up_at(grid, min(inside + vec3(0.0, 0.0, float(i)), last), found)) return found;
    }
    return LookUp(vec3(0.0), 0.0);
}
