// Walks along the curve, and the arcs that they leave for the solver. Work is done in chunks of pixel layers.
#include "shared/index.glsl"
#include "shared/optics.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "technique/mnee/arcs.glsl"
#include "technique/mnee/objective.glsl"
#include "technique/mnee/counters.glsl"

// Arcs that a pixel layer keeps for the solver, from all its walks and seeds.
const uint MAX_BRACKETS = 16u;

// One direction of a walk, between two triangles.
struct Walk {
    vec3 plane;      // unit normal of the plane through P, L and M, carried along
    float objective;
    vec3 at;         // M - P
    float tilt;      // cosine of the half vector to the axis of the surface's normals
    vec3 normal;     // interpolated, at M
    float place;     // on the boundary of `triangle`
    uint triangle;   // to be crossed next
    uint item;       // pixel layer, counted from the chunk's first
    uint start;      // triangle that holds the walk's first point
    uint steps;
};

// Part of the curve on which the objective has a zero, or may have two.
struct Bracket {
    vec2 from; // barycentrics
    vec2 to;
    uint triangle;
    uint steps; // from the walk's start; SPAN_ROUND: a whole ellipse
};

const uint SPAN_ROUND = 0x80000000u;

// Group counts of an indirect dispatch and the number of walks that it is for, a round of walking each.
struct Round {
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint walks;
};

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 3, binding = 3, std430) buffer Walks { Walk walks[]; };
layout(set = 3, binding = 4, std430) buffer Rounds { Round rounds[]; };
layout(set = 3, binding = 5, std430) buffer WalkLists { uint walk_lists[]; }; // two, for even and odd rounds
layout(set = 3, binding = 6, std430) buffer Brackets { Bracket brackets[]; };  // MAX_BRACKETS a pixel layer
layout(set = 3, binding = 7, std430) buffer BracketCounts { uint bracket_counts[]; };

Query query_at(VisiblePoint point, Light light) {
    Query query;
    query.point = point.position;
    query.directional = light.kind == LIGHT_DIRECTIONAL;
    query.light = query.directional ? -light.direction : light.position - point.position;
    query.point_index = media[point.medium].index;
    query.light_index = media[light.medium].index;
    return query;
}

// Has round `round` go on with `walk`. The capacity is that of one of the two lists.
bool append_walk(uint round, uint walk, uint capacity) {
    uint place = atomicAdd(rounds[round].walks, 1u);
    if (place >= capacity) return false;
    walk_lists[(round & 1u) * capacity + place] = walk;
    if (place % 64u == 0u) {
        atomicAdd(rounds[round].groups_x, 1u);
        rounds[round].groups_y = 1u;
        rounds[round].groups_z = 1u;
    }
    return true;
}

void append_bracket(uint item, Bracket bracket) {
    uint place = atomicAdd(bracket_counts[item], 1u);
    count(COUNT_ARCS, 1u);
    if (place < MAX_BRACKETS) {
        brackets[item * MAX_BRACKETS + place] = bracket;
    } else {
        count(COUNT_ARCS_DROPPED, 1u);
    }
}

// Whether the objective can be zero between two points of an arc: it changes its sign, or it could reach zero and come
// back within what half vector and normal turn by.
bool may_vanish(Query query, float before, float after, vec3 at_before, vec3 at_after, vec3 normal_before, vec3 normal_after) {
    if ((before < 0.0) != (after < 0.0)) return true;
    vec3 to_light = way_to_light(query, at_after);
    float turn = query.point_index * inversesqrt(max(dot(at_after, at_after), 1e-37));
    if (!query.directional) turn += query.light_index * inversesqrt(max(dot(to_light, to_light), 1e-37));
    float reach = turn * length(at_after - at_before) +
                  length(half_vector(query, at_after)) * length(normalize(normal_after) - normalize(normal_before));
    return abs(before) + abs(after) < reach;
}
