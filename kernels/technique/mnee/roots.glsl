// The roots of one visible point and light, each once, and what may be in the way of their paths.
#include "technique/mnee/path.glsl"
#include "trace/interface.glsl"

// Paths of one visible point and light that are told apart.
const uint MAX_PATHS = 24u;

struct Root {
    vec3 at; // M - P
    uint triangle;
    vec2 place;
};

bool comes_before(Root a, Root b) {
    if (a.triangle != b.triangle) return a.triangle < b.triangle;
    return a.place.x < b.place.x || (a.place.x == b.place.x && a.place.y < b.place.y);
}

// Adds a root to those found so far unless it is there. Roots are the same if rounding, or the two triangles of an edge,
// could have made one of the other; `same` is what they may be apart by.
void keep(inout Root roots[MAX_PATHS], inout uint number, Root root, float same) {
    for (uint i = 0u; i < number; i++) {
        if (distance(roots[i].at, root.at) < same) {
            // The lower one stays, whatever the order in which they were found.
            if (comes_before(root, roots[i])) roots[i] = root;
            count(COUNT_DUPLICATES, 1u);
            return;
        }
    }
    if (number == MAX_PATHS) {
        count(COUNT_ROOTS_DROPPED, 1u);
        return;
    }
    roots[number++] = root;
}

// Sums go by triangle, so that equal roots give equal bits.
void sort(inout Root roots[MAX_PATHS], uint number) {
    for (uint i = 1u; i < number; i++) {
        for (uint j = i; j > 0u && comes_before(roots[j], roots[j - 1u]); j--) {
            Root root = roots[j];
            roots[j] = roots[j - 1u];
            roots[j - 1u] = root;
        }
    }
}

// The path's segment between surface and light, or between visible point and surface.
Ray segment_of(Query query, Path path, bool to_light) {
    // As leave() in shared/surface.glsl; but M is P and a step from it, so that P's rounding is in it too.
    vec3 from = abs(query.point);
    float away = 2e-6 * max(max(path.reach, 1e-3), max(max(from.x, from.y), from.z));
    bool light_in_front = dot(path.to_light, path.geometric) > 0.0;
    vec3 off = away * (light_in_front == to_light ? path.geometric : -path.geometric);
    return to_light ? Ray(query.point + path.at + off, 0.0, path.to_light, path.light_distance)
                    : Ray(query.point, 0.0, path.at + off, 1.0);
}

// The counter of what is in the way, or 0.
uint obstacle(Hit hit) {
    if (hit.instance == NO_INSTANCE) return 0u;
    return instances[hit.instance].mask == MASK_SPECULAR ? COUNT_SECOND_CROSSING : COUNT_BLOCKED;
}
