// Bounds what each triangle's light can reach by the landings at its corners, and enters it into the grid.
#include "shared/index.glsl"
#include "shared/scene.glsl"
#include "technique/mnee/footprints.glsl"
#include "technique/mnee/counters.glsl"

layout(push_constant) uniform FootprintPush {
    vec3 low; // of the scene, m
    uint triangles;
    vec3 high;
} push;

// How far light lands outside of the corners' landings: refraction is not linear within the triangle. In parts of distance
// times the square of the angle between the corners' directions; an eighth would be the bulge of a circle's arc.
const float BULGE = 0.5;

// Cells of a level that are looked at for one footprint.
const int MAX_CELLS = 96;

// The stump of a cone round the corners' rays, from the nearest landing to the farthest. Something in the light's way that
// no corner's light meets is not known here.
Footprint bound(Landing corner[3], vec3 position[3]) {
    Footprint footprint = Footprint(vec3(0.0), 0.0, vec3(0.0), 0.0, 0.0, 0.0, NO_LEVEL, 0u);
    if (min(min(corner[0].distance, corner[1].distance), corner[2].distance) < 0.0) return footprint;
    footprint.origin = (position[0] + position[1] + position[2]) / 3.0;
    vec3 sum = corner[0].direction + corner[1].direction + corner[2].direction;
    float size = length(sum);
    // Directions all round have no axis; light that every corner sends elsewhere is a coarse mesh's, and left to walks.
    if (size < 0.5) return footprint;
    footprint.direction = sum / size;
    footprint.nearest = 1e30;
    footprint.farthest = -1e30;
    float turn = 0.0;
    float radius_there = 0.0;
    for (uint i = 0u; i < 3u; i++) {
        vec3 start = position[i] - footprint.origin;
        vec3 landed = start + corner[i].distance * corner[i].direction;
        float along = dot(landed, footprint.direction);
        footprint.nearest = min(footprint.nearest, along);
        footprint.farthest = max(footprint.farthest, along);
        footprint.radius = max(footprint.radius, length(start));
        turn = max(turn, distance(corner[i].direction, corner[i == 2u ? 0u : i + 1u].direction));
    }
    float reach = max(footprint.farthest, 1e-6);
    for (uint i = 0u; i < 3u; i++) {
        // Where the ray is off the axis by the most; the cosine keeps slanted rays from falling short.
        float cosine = max(dot(corner[i].direction, footprint.direction), 0.1);
        vec3 there = position[i] - footprint.origin + corner[i].direction * (reach / cosine);
        radius_there = max(radius_there, length(there - dot(there, footprint.direction) * footprint.direction));
    }
    float margin = BULGE * turn * turn * reach;
    float rounding = 1e-5 * (length(footprint.origin) + reach);
    footprint.radius += 1e-3 * footprint.radius + rounding;
    footprint.spread = max(radius_there + margin - footprint.radius, -0.5 * footprint.radius) / reach;
    // Between the landings a slanted receiver bulges as the light does; its triangle slants at the other end.
    float slack = margin + turn * (footprint.farthest - footprint.nearest) + footprint.radius + rounding;
    footprint.nearest -= slack;
    footprint.farthest += slack;
    footprint.level = LEVELS - 1u;
    return footprint;
}

void box_of(Footprint footprint, out vec3 low, out vec3 high) {
    vec3 first = footprint.origin + footprint.nearest * footprint.direction;
    vec3 last = footprint.origin + footprint.farthest * footprint.direction;
    float at_first = max(footprint.radius + footprint.spread * footprint.nearest, 0.0);
    float at_last = max(footprint.radius + footprint.spread * footprint.farthest, 0.0);
    low = max(min(first - at_first, last - at_last), push.low);
    high = min(max(first + at_first, last + at_last), push.high);
}

// Enters a footprint into the cells of a level that it touches; false where they are too many. With `enter` off nothing is
// changed.
bool enter_level(Footprint footprint, uint triangle, uint level, vec3 low, vec3 high, bool enter) {
    ivec3 first = footprint_cell(low, level);
    ivec3 cells = footprint_cell(high, level) - first + 1;
    if (any(greaterThan(cells, ivec3(MAX_CELLS))) || cells.x * cells.y * cells.z > MAX_CELLS) return false;
    float size = footprint_grid.cell * float(1u << level);
    uint number = 0u;
    uint buckets[CELLS];
    for (int i = 0; i < cells.x * cells.y * cells.z; i++) {
        ivec3 cell = first + ivec3(i % cells.x, (i / cells.x) % cells.y, i / (cells.x * cells.y));
        // Half the diagonal of a cube, and some for rounding.
        if (!holds(footprint, (vec3(cell) + 0.5) * size, 0.8661 * size)) continue;
        if (number == CELLS) return false;
        // Two cells of a triangle in one bucket are one entry.
        uint bucket = footprint_bucket(cell, level);
        bool known = false;
        for (uint j = 0u; j < number; j++) known = known || buckets[j] == bucket;
        if (known) continue;
        buckets[number] = bucket;
        if (enter) {
            uint entry = CELLS * triangle + number;
            footprint_next[entry] = atomicExchange(footprint_heads[bucket], entry);
        }
        number++;
    }
    return true;
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
    vec3 low;
    vec3 high;
    box_of(footprint, low, high);
    bool lit = min(min(corner[0].distance, corner[1].distance), corner[2].distance) >= 0.0;
    bool beside = any(greaterThan(low, high)); // of the scene
    if (beside) footprint.level = NO_LEVEL;
    bool entered = false;
    for (uint level = 0u; level < LEVELS && !entered && footprint.level != NO_LEVEL; level++) {
        if (!enter_level(footprint, index, level, low, high, false)) continue;
        entered = true;
        footprint.level = level;
        enter_level(footprint, index, level, low, high, true);
        atomicOr(footprint_grid.used, 1u << level);
    }
    if (!entered) footprint.level = NO_LEVEL;
    if (lit && !beside && !entered) count(COUNT_FOOTPRINTS_LEFT_OUT, 1u);
    footprints[index] = footprint;
}
