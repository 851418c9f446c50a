// Bounds what each triangle's light can reach by the landings at its corners, and enters the box into the grid.
#include "shared/index.glsl"
#include "technique/mnee/footprints.glsl"

layout(push_constant) uniform FootprintPush {
    vec3 low; // of the scene, m
    uint triangles;
    vec3 high;
} push;

// How far light lands outside of the corners' landings: refraction is not linear within the triangle. In parts of distance
// times the square of the angle between the corners' directions; an eighth would be the bulge of a circle's arc.
const float BULGE = 0.5;

void main() {
    uint index = linear_index();
    if (index >= push.triangles) return;
    SpecularTriangle triangle = specular_triangles[index];
    Landing corner[3];
    vec3 position[3];
    for (uint i = 0u; i < 3u; i++) {
        corner[i] = landings[triangle.corner[i]];
        position[i] = specular_vertices[triangle.corner[i]].position;
    }
    Footprint footprint = Footprint(vec3(0.0), NO_LEVEL, vec3(0.0), 0u);
    if (min(min(corner[0].distance, corner[1].distance), corner[2].distance) >= 0.0) {
        float nearest = min(min(corner[0].distance, corner[1].distance), corner[2].distance);
        float farthest = max(max(corner[0].distance, corner[1].distance), corner[2].distance);
        vec3 low = vec3(1e30);
        vec3 high = vec3(-1e30);
        float turn = 0.0;
        for (uint i = 0u; i < 3u; i++) {
            vec3 first = position[i] + nearest * corner[i].direction;
            vec3 last = position[i] + farthest * corner[i].direction;
            low = min(low, min(first, last));
            high = max(high, max(first, last));
            turn = max(turn, distance(corner[i].direction, corner[i == 2u ? 0u : i + 1u].direction));
        }
        float margin = BULGE * turn * (turn * farthest + (farthest - nearest)) + 1e-3 * distance(position[0], position[1]);
        vec3 reach = max(abs(low), abs(high));
        margin += 1e-5 * max(max(reach.x, reach.y), reach.z);
        footprint.low = max(low - margin, push.low);
        footprint.high = min(high + margin, push.high);
        vec3 extent = footprint.high - footprint.low;
        float largest = max(max(extent.x, extent.y), extent.z);
        if (min(min(extent.x, extent.y), extent.z) >= 0.0) {
            uint level = 0u;
            while (level + 1u < LEVELS && footprint_grid.cell * float(1u << level) < largest) level++;
            footprint.level = level;
        }
    }
    footprints[index] = footprint;
    if (footprint.level == NO_LEVEL) return;
    atomicOr(footprint_grid.used, 1u << footprint.level);
    ivec3 last = footprint_cell(footprint.high, footprint.level);
    for (uint i = 0u; i < CELLS; i++) {
        ivec3 cell = entry_cell(footprint, i);
        if (any(greaterThan(cell, last))) continue;
        uint entry = CELLS * index + i;
        footprint_next[entry] = atomicExchange(footprint_heads[footprint_bucket(cell, footprint.level)], entry);
    }
}
