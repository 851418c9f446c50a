// Starts the walks of a chunk of pixel layers: where the segment from the visible point to the light meets a surface
// between their two media, the coplanarity curve begins (Section 3.4.2). Both directions of it become a walk.
#include "technique/mnee/walks.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform StartPush {
    uint first_slot;
    uint items;
    uint light;
    uint capacity; // walks
    uint seeded;   // 0: no arcs are there yet; 1: only points without a certain one start a walk; 2: all do
} push;

// Surfaces that the segment may meet; those beyond are not looked for.
const uint MAX_MEETINGS = 8u;

// The first arc of a walk, from the start to crossing `exit`.
void set_out(Query query, Facet facet, uint item, uint triangle, vec2 start, float exit, float other_exit) {
    append_pierced(query, item, facet, triangle, start, boundary_barycentrics(exit), 0u);
    uint across = specular_triangles[triangle].across[min(uint(exit), 2u)];
    if (across == NO_TRIANGLE) {
        count(COUNT_ENDED_BOUNDARY, 1u);
        return;
    }
    vec3 weight = weights(boundary_barycentrics(exit));
    Walk walk;
    walk.at = facet_point(facet, weight);
    walk.normal = facet_normal(facet, weight);
    walk.objective = objective_at(query, walk.at, walk.normal);
    walk.tilt = -2.0;
    walk.triangle = across / 4u;
    walk.place = entry_across(across, exit);
    walk.item = item;
    walk.start = triangle;
    walk.steps = 1u;
    walk.start_ends = vec2(exit, other_exit);
    walk.padding0 = 0u;
    uint place = atomicAdd(rounds[0].walks, 1u);
    if (place >= push.capacity) {
        count(COUNT_WALKS_DROPPED, 1u);
        return;
    }
    walks[place] = walk;
    list_walk(0u, place, place, push.capacity);
}

// Both directions from a point on the curve inside of a triangle.
void start_walks(Query query, uint item, uint triangle, vec2 start) {
    Facet facet = facet_at(query, specular_triangles[triangle].corner);
    Crossings crossings = crossings_of(facet);
    count(COUNT_STARTS, 1u);
    append_point(item, triangle, start, 0u);
    if (crossings.count == 0u) {
        append_round(item, triangle, start, true);
        return;
    }
    uint first = 0u;
    uint second = 1u;
    for (uint i = 0u; crossings.count > 2u && i < crossings.count; i++) {
        uint other = partner(facet, crossings, i);
        if (other < i) continue;
        vec2 from = boundary_barycentrics(crossings.place[i]);
        vec2 to = boundary_barycentrics(crossings.place[other]);
        if (on_arc(facet, arc_between(facet, from, to, false), start, crossings.count)) {
            first = i;
            second = other;
        }
    }
    set_out(query, facet, item, triangle, start, crossings.place[first], crossings.place[second]);
    set_out(query, facet, item, triangle, start, crossings.place[second], crossings.place[first]);
}

void main() {
    uint item = linear_index();
    if (item >= push.items) return;
    uint slot = push.first_slot + item;
    VisiblePoint point = visible_points[slot];
    Light light = lights[push.light];
    bool lit = point.instance != NO_INSTANCE && point.medium != light.medium;
    if (push.seeded == 0u) {
        bracket_counts[item] = 0u;
        if (push.light == 0u) sample_irradiance[slot] = vec4(0.0);
        count(COUNT_POINTS, lit ? 1u : 0u);
    } else if (push.seeded == 1u && (bracket_counts[item] & CERTAIN) != 0u) {
        return;
    }
    if (!lit) return;
    Query query = query_at(point, light);

    float t = 0.0;
    for (uint i = 0u; i < MAX_MEETINGS; i++) {
        Hit hit = trace_closest(Ray(query.point, t, query.light, query.directional ? 1e30 : 1.0), MASK_SPECULAR);
        if (hit.instance == NO_INSTANCE) break;
        t = hit.t * (1.0 + 1e-6) + 1e-7;
        SpecularInstance instance = specular_instances[hit.instance];
        if (instance.first_triangle == NO_TRIANGLE) continue;
        Surface s = surface_at(hit.instance, hit.primitive, hit.barycentrics);
        bool from_front = dot(query.light, s.geometric) < 0.0;
        Material material = materials[s.material];
        uint here = from_front ? material.front : material.back;
        uint beyond = from_front ? material.back : material.front;
        if (here != point.medium || beyond != light.medium) continue;
        start_walks(query, item, instance.first_triangle + hit.primitive, hit.barycentrics);
    }
}
