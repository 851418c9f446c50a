// Media that absorb and scatter. A medium with a density grid has its coefficients times the density, trilinear between
// the grid's points and zero outside of its box.
#include "shared/math.glsl"
#include "shared/parts.glsl"
#include "shared/scene.glsl"

layout(set = 0, binding = 8, std430) readonly buffer DensityGrids { DensityGrid density_grids[]; };
layout(set = 0, binding = 9, std430) readonly buffer Voxels { float voxels[]; };

// EVEN_MEDIA is set in modules for scenes without grids.
uint grid_of(uint medium) {
#ifdef EVEN_MEDIA
    return NO_GRID;
#else
    return HAS_GRIDS ? media[medium].grid : NO_GRID;
#endif
}

bool scatters(uint medium) {
    return any(greaterThan(media[medium].scattering, vec3(0.0)));
}

// 1/m, where density is 1.
vec3 extinction(uint medium) {
    return media[medium].absorption + media[medium].scattering;
}

// Of what extinction takes, the part that is scattered.
vec3 scattered_part(uint medium) {
    vec3 all = extinction(medium);
    return mix(vec3(0.0), media[medium].scattering / max(all, vec3(1e-37)), greaterThan(all, vec3(0.0)));
}

// `at` counts cells from the grid's lower corner.
float density_in(DensityGrid grid, vec3 at) {
    vec3 inside = clamp(at, vec3(0.0), vec3(grid.points - 1u));
    uvec3 cell = min(uvec3(inside), grid.points - 2u);
    vec3 part = inside - vec3(cell);
    uint row = grid.points.x;
    uint slice = row * grid.points.y;
    uint first = grid.first_voxel + cell.z * slice + cell.y * row + cell.x;
    vec4 low = vec4(voxels[first], voxels[first + 1u], voxels[first + row], voxels[first + row + 1u]);
    first += slice;
    vec4 high = vec4(voxels[first], voxels[first + 1u], voxels[first + row], voxels[first + row + 1u]);
    vec4 face = mix(low, high, part.z);
    vec2 edge = mix(face.xy, face.zw, part.y);
    return mix(edge.x, edge.y, part.x);
}

float density_at(uint medium, vec3 position) {
    uint index = grid_of(medium);
    if (index == NO_GRID) return 1.0;
    DensityGrid grid = density_grids[index];
    vec3 at = (position - grid.lower) * grid.cells_per_metre;
    bool inside = all(greaterThanEqual(at, vec3(0.0))) && all(lessThanEqual(at, vec3(grid.points - 1u)));
    return inside ? density_in(grid, at) : 0.0;
}

// Of the ray's part within `length`, metres from `from` at which it enters and leaves the box of the medium's density;
// (0, length) for a medium without a grid. Where it misses the box, the first is not below the second.
vec2 dense_part(uint medium, vec3 from, vec3 direction, float length) {
    uint index = grid_of(medium);
    if (index == NO_GRID) return vec2(0.0, length);
    DensityGrid grid = density_grids[index];
    vec3 upper = grid.lower + vec3(grid.points - 1u) / grid.cells_per_metre;
    vec2 part = vec2(0.0, length);
    for (uint axis = 0u; axis < 3u; axis++) {
        float way = direction[axis];
        if (abs(way) < 1e-20) {
            if (from[axis] < grid.lower[axis] || from[axis] > upper[axis]) return vec2(0.0);
            continue;
        }
        float first = (grid.lower[axis] - from[axis]) / way;
        float second = (upper[axis] - from[axis]) / way;
        part = vec2(max(part.x, min(first, second)), min(part.y, max(first, second)));
    }
    return part;
}

// Where a walk along a ray through a medium stops.
struct March {
    float at;      // m from the ray's origin
    float depth;   // density integrated up to there, exact but for rounding: metres of density 1
    float even;    // the same, were density even in the cell of the grid where the walk stops
    float mean;    // density of that cell, in the mean over the ray's part in it
    float density; // there
};

const float ENDLESS = 1e30;

// A ray's way through a grid, from where it enters its box on. Origin and way count cells: a far origin's would cancel.
struct GridWalk {
    vec3 origin;
    vec3 way;  // per metre
    vec3 next; // m, the next plane across each axis
    vec3 step; // m, from plane to plane; 0 where the ray does not go along the axis, whose plane is the end
    float end; // m, where it leaves the box
    uint most; // cells, at most: a ray crosses each plane once; two more for those that it starts on and ends on
};

GridWalk grid_walk(DensityGrid grid, vec3 from, vec3 direction, vec2 part) {
    GridWalk walk;
    walk.origin = (from + part.x * direction - grid.lower) * grid.cells_per_metre;
    walk.way = direction * grid.cells_per_metre;
    walk.end = part.y - part.x;
    walk.next = vec3(walk.end);
    walk.step = vec3(0.0);
    for (uint axis = 0u; axis < 3u; axis++) {
        float way = walk.way[axis];
        if (abs(way) < 1e-20) continue;
        float plane = way > 0.0 ? floor(walk.origin[axis]) + 1.0 : ceil(walk.origin[axis]) - 1.0;
        walk.next[axis] = (plane - walk.origin[axis]) / way;
        walk.step[axis] = 1.0 / abs(way);
    }
    walk.most = grid.points.x + grid.points.y + grid.points.z + 2u;
    return walk;
}

// Where the cell that begins `at` metres on ends.
float cell_end(GridWalk walk, uint cell, float at) {
    if (cell + 1u >= walk.most) return walk.end;
    return max(min(min(walk.next.x, min(walk.next.y, walk.next.z)), walk.end), at);
}

void leave_cell(inout GridWalk walk, float until) {
    for (uint axis = 0u; axis < 3u; axis++) {
        if (walk.next[axis] > until) continue;
        walk.next[axis] = walk.step[axis] > 0.0 ? walk.next[axis] + walk.step[axis] : walk.end;
    }
}

// Walks `stop` metres along a ray of `length` metres, or until `even` is `target`. The ray is cut at the grid's planes;
// within a cell density is a cubic along it, which Simpson's rule integrates exactly.
March march(uint medium, vec3 from, vec3 direction, float length, float stop, float target) {
    uint index = grid_of(medium);
    if (index == NO_GRID) {
        float at = min(stop, target);
        return March(at, at, at, 1.0, 1.0);
    }
    March nowhere = March(length, 0.0, 0.0, 0.0, 0.0);
    vec2 part = dense_part(medium, from, direction, length);
    if (!(part.x < part.y) || stop < part.x) return nowhere;
    DensityGrid grid = density_grids[index];
    GridWalk walk = grid_walk(grid, from, direction, part);
    stop = min(stop - part.x, walk.end);
    float at = 0.0;
    float before = density_in(grid, walk.origin);
    float depth = 0.0;
    for (uint cell = 0u; cell < walk.most && at < walk.end; cell++) {
        float until = cell_end(walk, cell, at);
        float middle = density_in(grid, walk.origin + 0.5 * (at + until) * walk.way);
        float after = density_in(grid, walk.origin + until * walk.way);
        float mean = (before + 4.0 * middle + after) / 6.0;
        float gained = (until - at) * mean;
        if (until >= stop || depth + gained >= target) {
            float left = mean > 0.0 ? (target - depth) / mean : ENDLESS;
            float far = clamp(min(stop - at, left), 0.0, until - at);
            float there = density_in(grid, walk.origin + (at + far) * walk.way);
            float half_way = density_in(grid, walk.origin + (at + 0.5 * far) * walk.way);
            float exact = depth + far * (before + 4.0 * half_way + there) / 6.0;
            return March(part.x + at + far, exact, depth + far * mean, mean, there);
        }
        depth += gained;
        before = after;
        at = until;
        leave_cell(walk, until);
    }
    return March(length, depth, depth, 0.0, 0.0);
}

// Density along a ray, integrated over `length` metres: metres of density 1.
float density_along(uint medium, vec3 from, vec3 direction, float length) {
    uint index = grid_of(medium);
    if (index == NO_GRID) return length;
    vec2 part = dense_part(medium, from, direction, length);
    if (!(part.x < part.y)) return 0.0;
    DensityGrid grid = density_grids[index];
    GridWalk walk = grid_walk(grid, from, direction, part);
    float at = 0.0;
    float until = 0.0;
    float before = 0.0;
    float middle = 0.0;
    float depth = 0.0;
    // The start, then a middle and an end by turns: one look-up is all that is compiled.
    for (uint turn = 0u; turn <= 2u * walk.most && at < walk.end; turn++) {
        bool halfway = (turn & 1u) != 0u;
        if (halfway) until = cell_end(walk, turn / 2u, at);
        float found = density_in(grid, walk.origin + (halfway ? 0.5 * (at + until) : until) * walk.way);
        if (halfway) {
            middle = found;
            continue;
        }
        depth += (until - at) * (before + 4.0 * middle + found) / 6.0;
        before = found;
        at = until;
        if (turn > 0u) leave_cell(walk, until);
    }
    return depth;
}

// What `length` metres from `from` along the unit vector `direction` leave of light.
vec3 transmittance(uint medium, vec3 from, vec3 direction, float length) {
    vec3 lost = extinction(medium);
    // Also keeps 0 times a length without bound at 0.
    if (all(lessThanEqual(lost, vec3(0.0)))) return vec3(1.0);
    return exp(-lost * density_along(medium, from, direction, length));
}

// 1/m.
vec3 scattering_at(uint medium, vec3 position) {
    return media[medium].scattering * density_at(medium, position);
}

// Henyey and Greenstein's phase function, 1/sr; `cosine` is that between the light's direction before and after.
float phase(uint medium, float cosine) {
    float g = media[medium].asymmetry;
    // As (1 - g)^2 + 2 g (1 - cosine): 1 + g^2 - 2 g cosine cancels where g and the cosine are near 1.
    float spread = g >= 0.0 ? (1.0 - g) * (1.0 - g) + 2.0 * g * (1.0 - cosine)
                            : (1.0 + g) * (1.0 + g) - 2.0 * g * (1.0 + cosine);
    return (1.0 - g * g) / (4.0 * PI * spread * sqrt(spread));
}
