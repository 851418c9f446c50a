// Bounds what each triangle's light can reach by the landings at its corners, and enters the box into the grid.
#include "shared/index.glsl"
#include "shared/scene.glsl"
#include "technique/mnee/footprints.glsl"

layout(push_constant) uniform FootprintPush {
    vec3 low; // of the scene, m
    uint triangles;
    vec3 high;
} push;

// How far light lands outside of the corners' landings: refraction is not linear within the triangle. In parts of distance
// times the square of the angle between the corners' directions; an eighth would be the bulge of a circle's arc.
const float BULGE = 0.5;

// Of the cosine of incidence, for light that grazes what it lands on.
const float LEAST_COSINE = 0.05;

// Distance of a landing from the plane of another, over its distance from the light's surface, within which both are on one
// plane.
const float SAME_PLANE = 1e-4;

void include(inout Footprint footprint, vec3 point) {
    footprint.low = min(footprint.low, point);
    footprint.high = max(footprint.high, point);
}

// A box that holds wherever light lands that passes the triangle, unless something is in its way that no corner's light
// meets.
Footprint bound(Landing corner[3], vec3 position[3]) {
    Footprint footprint = Footprint(vec3(1e30), NO_LEVEL, vec3(-1e30), 0u);
    float nearest = min(min(corner[0].distance, corner[1].distance), corner[2].distance);
    float farthest = max(max(corner[0].distance, corner[1].distance), corner[2].distance);
    if (nearest < 0.0) return footprint;
    bool flat_there = corner[0].instance != NO_INSTANCE;
    float turn = 0.0;
    float cosine = 1.0;
    vec3 first = position[0] + corner[0].distance * corner[0].direction;
    for (uint i = 0u; i < 3u; i++) {
        vec3 landed = position[i] + corner[i].distance * corner[i].direction;
        flat_there = flat_there && corner[i].instance == corner[0].instance &&
                     dot(corner[i].normal, corner[0].normal) > 0.9999 &&
                     abs(dot(landed - first, corner[0].normal)) < SAME_PLANE * farthest;
        turn = max(turn, distance(corner[i].direction, corner[i == 2u ? 0u : i + 1u].direction));
        cosine = min(cosine, abs(dot(corner[i].direction, corner[i].normal)));
    }
    for (uint i = 0u; i < 3u; i++) {
        // On one plane light lands between the corners' landings. Else it may land anywhere between the nearest and the
        // farthest distance.
        include(footprint, position[i] + (flat_there ? corner[i].distance : nearest) * corner[i].direction);
        include(footprint, position[i] + (flat_there ? corner[i].distance : farthest) * corner[i].direction);
    }
    float spread = flat_there ? turn * farthest / max(cosine, LEAST_COSINE) : turn * farthest + (farthest - nearest);
    vec3 reach = max(abs(footprint.low), abs(footprint.high));
    float margin = BULGE * turn * spread + 1e-3 * distance(position[0], position[1]) +
                   1e-5 * max(max(reach.x, reach.y), reach.z);
    footprint.low = max(footprint.low - margin, push.low);
    footprint.high = min(footprint.high + margin, push.high);
    if (any(greaterThan(footprint.low, footprint.high))) return footprint;
    footprint.level = LEVELS - 1u;
    for (uint level = LEVELS - 1u; level-- > 0u;) {
        ivec3 cells = cells_of(footprint, level);
        if (any(greaterThan(cells, ivec3(CELLS))) || uint(cells.x * cells.y * cells.z) > CELLS) break;
        footprint.level = level;
    }
    return footprint;
}

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
    Footprint footprint = bound(corner, position);
    footprints[index] = footprint;
    if (footprint.level == NO_LEVEL) return;
    atomicOr(footprint_grid.used, 1u << footprint.level);
    ivec3 low = footprint_cell(footprint.low, footprint.level);
    ivec3 cells = cells_of(footprint, footprint.level);
    uint number = min(uint(cells.x * cells.y * cells.z), CELLS);
    for (uint i = 0u; i < number; i++) {
        ivec3 cell = low + ivec3(int(i) % cells.x, (int(i) / cells.x) % cells.y, int(i) / (cells.x * cells.y));
        uint entry = CELLS * index + i;
        footprint_next[entry] = atomicExchange(footprint_heads[footprint_bucket(cell, footprint.level)], entry);
    }
}
