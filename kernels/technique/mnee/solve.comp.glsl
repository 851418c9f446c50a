// Finds the zeros on the arcs that walks and seeds left, each once, and adds the light of those paths that nothing
// blocks.
#include "technique/mnee/walks.glsl"
#include "technique/mnee/roots.glsl"
#include "technique/mnee/manifold.glsl"

layout(set = 2, binding = 12, std430) buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform SolvePush {
    uint first_slot;
    uint items;
    uint light;
    uint one;    // 1: the first path along the walk only
    float width; // pixels from a fold within which irradiance is a mean
} push;

// Steps of Newton's method from where the line PL meets a triangle; near by it takes three.
const uint NEWTON_STEPS = 6u;

// Of a step in barycentrics, that is too small to matter.
const float NEWTON_REST = 1e-5;

// The root that Newton's method finds within the triangle, if it does.
bool newton(Query query, uint triangle, inout vec2 place) {
    float rest = 1.0;
    for (uint i = 0u; i < NEWTON_STEPS && rest > NEWTON_REST; i++) {
        vec2 step = guess_at(query, triangle, place).place_step;
        rest = length(step);
        // A linear model is no better than the triangle is large.
        place += step * min(1.0, 1.0 / max(rest, 1e-37));
    }
    // A NaN is not inside.
    return rest <= NEWTON_REST && min(min(place.x, place.y), 1.0 - place.x - place.y) >= 0.0;
}

// Whether an arc is before another along the walks; of both directions' equally far, by number.
bool is_nearer(uint item, uint first, uint second) {
    Bracket a = brackets[item * MAX_BRACKETS + first];
    Bracket b = brackets[item * MAX_BRACKETS + second];
    if ((a.steps & ARC_STEPS) != (b.steps & ARC_STEPS)) return (a.steps & ARC_STEPS) < (b.steps & ARC_STEPS);
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.to.x < b.to.x || (a.to.x == b.to.x && a.to.y < b.to.y);
}

void main() {
    uint item = linear_index();
    if (item >= push.items) return;
    uint arcs = min(bracket_counts[item] & ~CERTAIN, MAX_BRACKETS);
    if (arcs == 0u) return;
    uint slot = push.first_slot + item;
    VisiblePoint point = visible_points[slot];
    Light light = lights[push.light];
    Query query = query_at(point, light);

    Root roots[MAX_PATHS];
    uint number = 0u;
    uint tried = 0u; // a bit an arc, where only the first path is wanted
    for (uint i = 0u; i < arcs && !(push.one != 0u && number > 0u); i++) {
        uint pick = i;
        if (push.one != 0u) {
            pick = MAX_BRACKETS;
            for (uint j = 0u; j < arcs; j++) {
                bool untried = ((tried >> j) & 1u) == 0u;
                if (untried && (pick == MAX_BRACKETS || is_nearer(item, j, pick))) pick = j;
            }
            tried |= 1u << pick;
        }
        Bracket bracket = brackets[item * MAX_BRACKETS + pick];
        Facet facet = facet_at(query, specular_triangles[bracket.triangle].corner);
        Arc arc = arc_of(facet, bracket);
        float size = distance(facet.at[0], facet.at[1]);
        Interval intervals[INTERVALS];
        if ((bracket.steps & ARC_POINT) != 0u) {
            Root root;
            root.triangle = bracket.triangle;
            root.place = bracket.from;
            if (newton(query, root.triangle, root.place)) {
                root.at = facet_point(facet, weights(root.place));
                keep(roots, number, root, 1e-4 * size + 2e-6 * length(root.at));
            }
            continue;
        }
        uint zeros = intervals_of(query, facet, arc, intervals);
        for (uint j = 0u; j < zeros; j++) {
            Root root;
            if (!refine(query, facet, arc, intervals[j], root.place)) {
                count(COUNT_UNSOLVED, 1u);
                continue;
            }
            root.triangle = bracket.triangle;
            root.at = facet_point(facet, weights(root.place));
            keep(roots, number, root, 1e-4 * size + 2e-6 * length(root.at));
            if (push.one != 0u) break;
        }
    }
    sort(roots, number);
    count(COUNT_ROOTS, number);

    // Each path's two segments, the second only if the first is free.
    vec3 sum = vec3(0.0);
    Path path;
    uint paths = 0u;
    for (uint segment = 0u; segment < 2u * number; segment++) {
        uint index = segment / 2u;
        bool to_light = (segment & 1u) != 0u;
        if (!to_light) {
            path = path_at(query, point, light, roots[index].triangle, roots[index].place,
                           push.width * point.footprint);
            if (path.rejected != 0u) count(path.rejected, 1u);
        }
        if (path.rejected != 0u) continue;
        path.rejected = obstacle(trace(segment_of(query, path, to_light), MASK_ALL, true));
        if (path.rejected != 0u) {
            count(path.rejected, 1u);
        } else if (to_light) {
            sum += path.irradiance;
            paths++;
        }
    }
    count(COUNT_PATHS, paths);
    sample_irradiance[slot].rgb += sum;
}
