// Walks on from triangle to triangle (Section 3.4.3), some steps a round; walks that are not at their end go on in the next
// round, packed together, so that a long one holds nobody up.
#include "technique/mnee/walks.glsl"

layout(push_constant) uniform WalkPush {
    uint first_slot;
    uint light;
    uint capacity;  // walks
    uint round;
    uint max_steps; // this round's
    uint last;      // 1: no round follows
    uint one;       // 1: a walk ends at its first change of sign
} push;

// Of places on the boundary of a triangle: crossings are found from the same numbers each time.
const float SAME_PLACE = 1e-5;

// No more steps than this lead away from every slope before a walk ends.
const uint PATIENCE = 2u;

void main() {
    uint place = linear_index();
    if (place >= min(rounds[push.round].walks, push.capacity)) return;
    uint index = walk_lists[(push.round & 1u) * push.capacity + place];
    Walk walk = walks[index];
    VisiblePoint point = visible_points[push.first_slot + walk.item];
    Query query = query_at(point, lights[push.light]);

    uint crossed = 0u;
    uint away = 0u;
    uint end = COUNT_STEP_CAP;
    for (; crossed < push.max_steps; crossed++) {
        SpecularTriangle triangle = specular_triangles[walk.triangle];
        Facet facet = facet_at(query, triangle.corner);
        Crossings crossings = crossings_of(facet);
        uint entry = 6u;
        float nearest = 2.0;
        for (uint i = 0u; i < crossings.count; i++) {
            float distance = abs(crossings.place[i] - walk.place);
            if (uint(crossings.place[i]) == uint(walk.place) && distance < nearest) {
                nearest = distance;
                entry = i;
            }
        }
        if (entry == 6u) {
            end = COUNT_ENDED_CREASE;
            break;
        }
        float exit = crossings.place[partner(facet, crossings, entry)];
        vec2 to = boundary_barycentrics(exit);
        vec3 at = facet_point(facet, weights(to));
        vec3 normal = facet_normal(facet, weights(to));
        float value = objective_at(query, at, normal);
        vec2 pierced;
        if (is_pierced(facet, pierced) ||
            may_vanish(query, walk.objective, value, walk.at, at, walk.normal, normal)) {
            vec2 from = boundary_barycentrics(crossings.place[entry]);
            append_arc(query, walk.item, facet, walk.triangle, from, to, crossings.count, walk.steps);
        }
        walk.steps++;
        if (walk.triangle == walk.start &&
            any(lessThan(abs(walk.start_ends - crossings.place[entry]), vec2(SAME_PLACE)))) {
            // The arc through the start was left at both ends; who comes back by one of them has been all round.
            crossed++;
            end = COUNT_ENDED_CLOSED;
            break;
        }
        if (push.one != 0u && (value < 0.0) != (walk.objective < 0.0)) {
            crossed++;
            end = COUNT_ENDED_FOUND;
            break;
        }
        walk.at = at;
        walk.normal = normal;
        walk.objective = value;
        uint across = triangle.across[min(uint(exit), 2u)];
        if (across == NO_TRIANGLE) {
            crossed++;
            end = COUNT_ENDED_BOUNDARY;
            break;
        }
        // Where the half vector is outside of the cone of all normals there is no root, and if it goes on leaving there
        // will be none.
        SpecularInstance instance = specular_instances[triangle.instance];
        float tilt = abs(dot(normalize(half_vector(query, at)), instance.axis));
        bool outside = tilt < instance.cos_spread;
        away = outside && tilt < walk.tilt ? away + 1u : 0u;
        walk.tilt = tilt;
        walk.triangle = across / 4u;
        walk.place = entry_across(across, exit);
        if (away > PATIENCE) {
            crossed++;
            end = COUNT_ENDED_SLOPES;
            break;
        }
    }
    count(COUNT_TRIANGLES, crossed);
    if (end == COUNT_STEP_CAP && push.last == 0u) {
        walks[index] = walk;
        uint next = atomicAdd(rounds[push.round + 1u].walks, 1u);
        list_walk(push.round + 1u, next, index, push.capacity);
        return;
    }
    count(end, 1u);
    atomicMax(mnee_counters[LONGEST_WALK], walk.steps);
}
