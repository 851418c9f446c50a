// Hands the solver the arcs of all triangles whose light may land on the visible point.
#include "technique/mnee/walks.glsl"
#include "technique/mnee/footprints.glsl"

layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform SeedPush {
    uint first_slot;
    uint items;
    uint light;
} push;

// Entries of one bucket that are looked at.
const uint MAX_ENTRIES = 1u << 16;

// The pieces of the curve in a triangle, where they may hold a zero.
void append_arcs(Query query, uint item, uint triangle) {
    Facet facet = facet_at(query, specular_triangles[triangle].corner);
    float low = min(min(min(facet.corner[0], facet.corner[1]), facet.corner[2]),
                    min(min(facet.edge[0], facet.edge[1]), facet.edge[2]));
    float high = max(max(max(facet.corner[0], facet.corner[1]), facet.corner[2]),
                     max(max(facet.edge[0], facet.edge[1]), facet.edge[2]));
    // A quadratic stays between its Bernstein coefficients.
    if (low > 0.0 || high < 0.0) return;
    count(COUNT_SEEDS, 1u);
    Crossings crossings = crossings_of(facet);
    vec2 place;
    if (crossings.count == 0u && is_pierced(facet, place)) {
        append_point(item, triangle, place, 0u);
        append_round(item, triangle, place, true);
    } else if (crossings.count == 0u && ellipse_inside(facet, place)) {
        append_round(item, triangle, place, false);
    }
    for (uint i = 0u; i < crossings.count; i++) {
        uint other = partner(facet, crossings, i);
        if (other < i) continue;
        vec2 from = boundary_barycentrics(crossings.place[i]);
        vec2 to = boundary_barycentrics(crossings.place[other]);
        append_arc(query, item, facet, triangle, from, to, crossings.count, 0u);
    }
}

void main() {
    uint item = linear_index();
    if (item >= push.items) return;
    uint slot = push.first_slot + item;
    bracket_counts[item] = 0u;
    if (push.light == 0u) sample_irradiance[slot] = vec4(0.0);
    VisiblePoint point = visible_points[slot];
    Light light = lights[push.light];
    if (point.instance == NO_INSTANCE || point.medium == light.medium) return;
    count(COUNT_POINTS, 1u);
    Query query = query_at(point, light);
    for (uint levels = footprint_grid.used; levels != 0u; levels &= levels - 1u) {
        uint level = uint(findLSB(levels));
        ivec3 cell = footprint_cell(point.position, level);
        uint entry = footprint_heads[footprint_bucket(cell, level)];
        for (uint i = 0u; i < MAX_ENTRIES && entry != NO_ENTRY; i++) {
            uint triangle = entry / CELLS;
            Footprint footprint = footprints[triangle];
            // Other cells and levels share the bucket.
            if (footprint.level == level && holds(footprint, point.position, 0.0)) {
                append_arcs(query, item, triangle);
            }
            entry = footprint_next[entry];
        }
    }
}
