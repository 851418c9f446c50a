// What a volume says of a place between its cells. The kernel that includes this declares the buffers `values` and
// `cell_lights`.
#include "technique/eikonal/slopes.glsl"

struct LookUp {
    vec3 way;    // unit, world space: where light goes
    float light; // as cell_lights has it; 0 where nothing is known
};

// Planes below a place that are looked at where it has the surface on all sides.
const int DEEPER = 2;
// Cells beside the grid that are taken for those at its sides.
const float BESIDE = 1.5;

// Of the cells around a place, the one on a corner of theirs.
struct Corner {
    ivec3 cell;
    float weight; // trilinear
};

Corner corner_of(vec3 at, int corner) {
    vec3 low = floor(at);
    ivec3 bit = ivec3(corner & 1, (corner >> 1) & 1, corner >> 2);
    vec3 share = mix(1.0 - (at - low), at - low, vec3(bit));
    return Corner(ivec3(low) + bit, share.x * share.y * share.z);
}

bool inside(EikonalGrid grid, ivec3 cell) {
    return all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, ivec3(grid.cells)));
}

// Trilinear over what is known around.
bool look_up_at(EikonalGrid grid, vec3 at, bool staggered, out LookUp found) {
    vec3 rise = vec3(0.0);
    vec2 light = vec2(0.0); // and its weight
    vec3 between = at;
    if (staggered) between = clamp(at - vec3(0.5, 0.5, 0.0), vec3(0.0), max(vec3(grid.cells) - vec3(2.0, 2.0, 1.0), 0.0));
    for (int i = 0; i < 8; i++) {
        Corner corner = corner_of(at, i);
        float here = corner.weight > 0.0 ? wave_at(grid, corner.cell) : UNKNOWN;
        if (here < UNKNOWN) rise += corner.weight * rise_at_cell(grid, corner.cell, here);
        corner = corner_of(between, i);
        float lit = corner.weight > 0.0 && inside(grid, corner.cell) ? cell_lights[cell_index(grid, corner.cell)] : UNLIT;
        if (lit >= 0.0) light += corner.weight * vec2(lit, 1.0);
    }
    float steep = length(rise);
    found = LookUp(turn_to_world(grid, rise / max(steep, 1e-20)), light.x / max(light.y, 1e-20));
    return light.y > 0.0 && steep > 0.0;
}

// Light is in cells or, `staggered`, between them as light.comp.glsl leaves it.
LookUp look_up(EikonalGrid grid, vec3 world, bool staggered) {
    LookUp found = LookUp(vec3(0.0), 0.0);
    vec3 at = to_cells(grid, world);
    vec3 last = vec3(grid.cells) - 1.0;
    vec3 nearest = clamp(at, vec3(0.0), last);
    vec3 beside = abs(at - nearest);
    if (max(max(beside.x, beside.y), beside.z) > BESIDE) return found;
    for (int i = 0; i <= DEEPER; i++) {
        if (look_up_at(grid, min(nearest + vec3(0.0, 0.0, float(i)), last), staggered, found)) return found;
    }
    return LookUp(vec3(0.0), 0.0);
}
