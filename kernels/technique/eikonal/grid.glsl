// A grid of cubic cells, and the order in which light goes through it: planes one after the other along one axis, columns
// across them. Structs as in renderer/technique/eikonal/device.rs.

struct EikonalGrid {
    vec3 lower;    // m, the box's lower corner
    float cell;    // m
    uvec3 cells;   // along u, v and the way of planes
    float index;   // refractive index where the wave goes
    ivec3 strides; // from one cell to the next along u, v and the way of planes
    int first;     // index of cell (0, 0, 0) of columns and planes
    uvec3 axes;    // of the world: u, v, planes
    uint backward; // 1: planes go down their axis
};

// Not part of the wave's medium; above all values.
const float OUTSIDE = 3.0e38;
// No value yet, and one is wanted from the surface.
const float WANTED = 2.0e30;
// No value yet.
const float UNKNOWN = 1.0e30;
// In place of light: not known.
const float UNLIT = -1.0e30;
// Sign bit of a value that is given and stays.
const uint GIVEN = 0x80000000u;

int cell_index(EikonalGrid grid, ivec3 at) {
    return grid.first + at.x * grid.strides.x + at.y * grid.strides.y + at.z * grid.strides.z;
}

// A place in columns and planes, in cells: whole numbers are middles.
vec3 to_cells(EikonalGrid grid, vec3 world) {
    vec3 scaled = (world - grid.lower) / grid.cell - 0.5;
    vec3 at = vec3(scaled[grid.axes.x], scaled[grid.axes.y], scaled[grid.axes.z]);
    if (grid.backward != 0u) at.z = float(grid.cells.z - 1u) - at.z;
    return at;
}

vec3 to_world(EikonalGrid grid, vec3 at) {
    if (grid.backward != 0u) at.z = float(grid.cells.z - 1u) - at.z;
    vec3 world;
    world[grid.axes.x] = at.x;
    world[grid.axes.y] = at.y;
    world[grid.axes.z] = at.z;
    return grid.lower + (world + 0.5) * grid.cell;
}

// A direction of the world in columns and planes.
vec3 turn_to_cells(EikonalGrid grid, vec3 world) {
    vec3 at = vec3(world[grid.axes.x], world[grid.axes.y], world[grid.axes.z]);
    return grid.backward != 0u ? vec3(at.xy, -at.z) : at;
}

// The other way round from turn_to_cells.
vec3 turn_to_world(EikonalGrid grid, vec3 at) {
    if (grid.backward != 0u) at.z = -at.z;
    vec3 world;
    world[grid.axes.x] = at.x;
    world[grid.axes.y] = at.y;
    world[grid.axes.z] = at.z;
    return world;
}
