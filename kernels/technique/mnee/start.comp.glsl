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
    uint walk;     // 0: nothing is walked
} push;

// Surfaces that the segment may meet; those beyond are not looked for.
const uint MAX_MEETINGS = 8u;

// The first arc of a walk, from the start to crossing `exit`.
void set_out(Query query, Facet facet, uint item, uint triangle, vec2 start, float exit, float objective_start) {
    SpecularTriangle neighbours = specular_triangles[triangle];
    vec3 weight = weights(boundary_barycentrics(exit));
    Walk walk;
    walk.at = facet_point(facet, weight);
    walk.normal = facet_normal(facet, weight);
    walk.plane = plane_normal(query, walk.at);
    walk.objective = objective(query, walk.at, walk.normal, walk.plane);
    vec3 at_start = facet_point(facet, weights(start));
    vec3 normal_start = facet_normal(facet, weights(start));
    if (may_vanish(query, objective_start, walk.objective, at_start, walk.at, normal_start, walk.normal)) {
        append_bracket(item, Bracket(start, boundary_barycentrics(exit), triangle, 0u));
    }
    uint across = neighbours.across[min(uint(exit), 2u)];
    if (across == NO_TRIANGLE) {
        count(COUNT_ENDED_BOUNDARY, 1u);
        return;
    }
    walk.tilt = -2.0;
    walk.triangle = across / 4u;
    walk.place = float(across % 4u) + 1.0 - fract(exit);
    walk.item = item;
    walk.start = triangle;
    walk.steps = 1u;
    uint place = atomicAdd(rounds[0].walks, 1u);
    if (place >= push.capacity) {
        count(COUNT_WALKS_DROPPED, 1u);
        return;
    }
    walks[place] = walk;
    walk_lists[place] = place;
    if (place % 64u == 0u) {
        atomicAdd(rounds[0].groups_x, 1u);
        rounds[0].groups_y = 1u;
        rounds[0].groups_z = 1u;
    }
}

// Both directions from a point on the curve inside of a triangle.
void start_walks(Query query, uint item, uint triangle, vec2 start) {
    Facet facet = facet_at(query, specular_triangles[triangle].corner);
    Crossings crossings = crossings_of(facet);
    count(COUNT_STARTS, 1u);
    if (crossings.count == 0u) {
        append_bracket(item, Bracket(start, start, triangle, SPAN_ROUND));
        return;
    }
    uint first = 0u;
    uint second = 1u;
    float nearest = 1e30;
    for (uint i = 0u; crossings.count > 2u && i < crossings.count; i++) {
        uint other = partner(facet, crossings, i);
        if (other < i) continue;
        Arc arc = Arc(boundary_barycentrics(crossings.place[i]), boundary_barycentrics(crossings.place[other]), false);
        vec2 chord = arc.to - arc.from;
        float part = clamp(dot(start - arc.from, chord) / max(dot(chord, chord), 1e-37), 0.0, 1.0);
        float distance = length(arc_point(facet, arc, part) - start);
        if (distance < nearest) {
            nearest = distance;
            first = i;
            second = other;
        }
    }
    // At the start the plane through P, L and M is undefined. Its limit along the curve depends on the direction by its
    // sign alone, and one sign is the other's opposite: a root that lies just at the start is found once.
    vec3 towards = facet_point(facet, weights(boundary_barycentrics(crossings.place[first])));
    vec3 weight = weights(start);
    float here = objective(query, facet_point(facet, weight), facet_normal(facet, weight), plane_normal(query, towards));
    set_out(query, facet, item, triangle, start, crossings.place[first], here >= 0.0 ? max(here, 1e-37) : here);
    set_out(query, facet, item, triangle, start, crossings.place[second], here >= 0.0 ? min(-here, -1e-37) : -here);
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
    if (push.walk == 0u) return;
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
