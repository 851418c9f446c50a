// Where each refracting triangle's light can land: boxes in a hashed grid of several levels, so that a visible point finds
// the triangles that may light it. The curve through the start is one of several where the surface folds light; the
// triangles on the others are found here.
#include "technique/mnee/surface.glsl"

struct Landing {
    vec3 direction; // of light refracted at a vertex
    float distance; // to the first diffuse surface, m; negative: the light does not reach the vertex's instance
    vec3 normal;    // there, unit; zero where nothing is met
    uint instance;  // there
};

struct Footprint { // a box, world space
    vec3 low;
    uint level; // NO_LEVEL: light does not pass
    vec3 high;
    uint padding0;
};

const uint NO_LEVEL = 0xffffffffu;

// Each level's cells are twice as large as the one's before. A box is in the lowest level where it needs no more than CELLS
// cells: long boxes, where light grazes a wall, are in as fine a level as short ones.
const uint LEVELS = 16u;
const uint CELLS = 16u; // a triangle's entries, some of them unused
const uint NO_ENTRY = 0xffffffffu;

struct FootprintGrid {
    float cell; // m, of level 0; a power of two, so that dividing by it is exact
    uint buckets; // a power of two
    uint used;    // a bit a level
    uint padding0;
};

layout(set = 3, binding = 9, std430) buffer Landings { Landing landings[]; };          // one a specular vertex
layout(set = 3, binding = 10, std430) buffer Footprints { Footprint footprints[]; };   // one a specular triangle
layout(set = 3, binding = 11, std430) buffer FootprintGrids { FootprintGrid footprint_grid; };
layout(set = 3, binding = 12, std430) buffer FootprintHeads { uint footprint_heads[]; }; // of lists, one a bucket
layout(set = 3, binding = 13, std430) buffer FootprintNext { uint footprint_next[]; };   // CELLS a triangle

ivec3 footprint_cell(vec3 position, uint level) {
    float size = footprint_grid.cell * float(1u << level);
    return ivec3(clamp(floor(position / size), vec3(-1e9), vec3(1e9)));
}

uint footprint_bucket(ivec3 cell, uint level) {
    uint h = uint(cell.x) * 0x8da6b343u ^ uint(cell.y) * 0xd8163841u ^ uint(cell.z) * 0xcb1ab31fu ^ level * 0x9e3779b9u;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 13;
    return h & (footprint_grid.buckets - 1u);
}

// Cells along each axis that a box has a part of.
ivec3 cells_of(Footprint footprint, uint level) {
    return footprint_cell(footprint.high, level) - footprint_cell(footprint.low, level) + 1;
}

// Of a triangle's entries, the number of the one in a cell that its box has a part of.
uint entry_in(Footprint footprint, ivec3 cell) {
    ivec3 cells = cells_of(footprint, footprint.level);
    ivec3 at = cell - footprint_cell(footprint.low, footprint.level);
    return uint((at.z * cells.y + at.y) * cells.x + at.x);
}
