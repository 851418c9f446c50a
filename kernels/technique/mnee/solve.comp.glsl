// Finds the zeros on the arcs that walks and seeds left, each once, and adds the light of those paths that nothing
// blocks.
#include "technique/mnee/walks.glsl"
#include "technique/mnee/path.glsl"
#include "technique/mnee/zeros.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 12, std430) buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform SolvePush {
    uint first_slot;
    uint items;
    uint light;
    uint one; // 1: the first path along the walk only
} push;

// Paths of one visible point and light that are told apart.
const uint MAX_PATHS = 12u;

struct Root {
    vec3 at;
    uint triangle;
    vec2 place;
};

// Adds a root to those found so far unless it is there. Roots are the same if rounding, or the two triangles of an edge,
// could have made one of the other.
void keep(inout Root roots[MAX_PATHS], inout uint number, Root root, float size) {
    float same = 1e-4 * size + 2e-6 * length(root.at);
    for (uint i = 0u; i < number; i++) {
        if (distance(roots[i].at, root.at) < same) {
            // The lower triangle stays, whatever the order in which they were found.
            if (root.triangle < roots[i].triangle) roots[i] = root;
            count(COUNT_DUPLICATES, 1u);
            return;
        }
    }
    if (number == MAX_PATHS) {
        count(COUNT_ARCS_DROPPED, 1u);
        return;
    }
    roots[number++] = root;
}

bool comes_before(Root a, Root b) {
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.place.x < b.place.x || (a.place.x == b.place.x && a.place.y < b.place.y);
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
            uint least = 0xffffffffu;
            for (uint j = 0u; j < arcs; j++) {
                uint steps = brackets[item * MAX_BRACKETS + j].steps & ARC_STEPS;
                if (((tried >> j) & 1u) == 0u && steps < least) {
                    least = steps;
                    pick = j;
                }
            }
            tried |= 1u << pick;
        }
        Bracket bracket = brackets[item * MAX_BRACKETS + pick];
        Facet facet = facet_at(query, specular_triangles[bracket.triangle].corner);
        Arc arc = arc_of(bracket);
        float size = distance(facet.at[0], facet.at[1]);
        Interval intervals[MAX_INTERVALS];
        bool point_only = (bracket.steps & ARC_POINT) != 0u;
        uint zeros = point_only ? 1u : intervals_of(query, facet, arc, intervals);
        for (uint j = 0u; j < zeros; j++) {
            Root root;
            root.place = bracket.from;
            if (!point_only && !refine(query, facet, arc, intervals[j], root.place)) {
                count(COUNT_UNSOLVED, 1u);
                continue;
            }
            root.triangle = bracket.triangle;
            root.at = facet_point(facet, weights(root.place));
            keep(roots, number, root, size);
            if (push.one != 0u) break;
        }
    }
    // Sums go by triangle, so that equal roots give equal bits.
    for (uint i = 1u; i < number; i++) {
        for (uint j = i; j > 0u && comes_before(roots[j], roots[j - 1u]); j--) {
            Root root = roots[j];
            roots[j] = roots[j - 1u];
            roots[j - 1u] = root;
        }
    }
    count(COUNT_ROOTS, number);

    // Each path's two segments, the second only if the first is free.
    vec3 sum = vec3(0.0);
    Path path;
    uint paths = 0u;
    for (uint segment = 0u; segment < 2u * number; segment++) {
        uint index = segment / 2u;
        bool to_light = (segment & 1u) != 0u;
        if (!to_light) {
            path = path_at(query, point, light, roots[index].triangle, roots[index].place);
            if (path.rejected != 0u) count(path.rejected, 1u);
        }
        if (path.rejected != 0u) continue;
        vec3 surface = query.point + path.at;
        float away = 2e-6 * max(path.reach, 1e-3); // as leave() in shared/surface.glsl
        bool light_in_front = dot(path.to_light, path.geometric) > 0.0;
        vec3 off = away * (light_in_front == to_light ? path.geometric : -path.geometric);
        Ray ray = to_light ? Ray(surface + off, 0.0, path.to_light, path.light_distance)
                           : Ray(query.point, 0.0, path.at + off, 1.0);
        Hit hit = trace(ray, MASK_ALL, true);
        if (hit.instance != NO_INSTANCE) {
            path.rejected = instances[hit.instance].mask == MASK_SPECULAR ? COUNT_SECOND_CROSSING : COUNT_BLOCKED;
            count(path.rejected, 1u);
        } else if (to_light) {
            sum += path.irradiance;
            paths++;
        }
    }
    count(COUNT_PATHS, paths);
    sample_irradiance[slot].rgb += sum;
}
