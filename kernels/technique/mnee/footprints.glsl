// Where each refracting triangle's light can land: stumps of cones in a hashed grid of several levels, so that a visible point finds
// the triangles that may light it. The curve through the start is one of several where the surface folds light; the
// triangles on the others are found here.
#include "technique/mnee/surface.glsl"

struct Landing {
    vec3 direction; // of light refracted at a vertex
    float distance; // to the first diffuse surface, m; negative: the light does not reach the vertex's instance
};

// What light can reach that passes a triangle: a piece of a cone's stump.
struct Footprint {
    vec3 origin;      // on the axis, at the triangle
    float radius;     // there, m
    vec3 direction;   // unit, along the axis
    float spread;     // of the radius, a metre of axis
    float nearest;    // on the axis, m
    float farthest;
    uint level;       // of the grid; NO_LEVEL: light does not pass
    uint padding0;
};

const uint NO_LEVEL = 0xffffffffu;

// Each level's cells are twice as large as the one's before. A footprint is in the lowest level where it touches no more
// than CELLS cells.
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

bool holds(Footprint footprint, vec3 position, float margin) {
    vec3 way = position - footprint.origin;
    float along = dot(way, footprint.direction);
    float radius = footprint.radius + footprint.spread * along + margin;
    vec3 off = way - along * footprint.direction;
    return along > footprint.nearest - margin && along < footprint.farthest + margin && dot(off, off) < radius * radius;
}
