// Walks along the curve, and the arcs that they leave for the solver. Work is done in chunks of pixel layers.
#include "technique/mnee/query.glsl"
#include "technique/mnee/zeros.glsl"
#include "technique/mnee/counters.glsl"

// Arcs that a pixel layer keeps for the solver, from all its walks and seeds.
const uint MAX_BRACKETS = 32u;

// One direction of a walk, between two triangles.
struct Walk {
    vec3 at;         // M - P
    float objective;
    vec3 normal;     // interpolated, at M
    float tilt;      // cosine of the half vector to the axis of the surface's normals
    float place;     // on the boundary of `triangle`
    uint triangle;   // to be crossed next
    uint item;       // pixel layer, counted from the chunk's first
    uint start;      // triangle that holds the walk's first point
    uint steps;
    uint padding0;
    vec2 start_ends; // where the arc through that point crosses the triangle's boundary
};

// Part of the curve on which the objective has a zero, or may have two.
struct Bracket {
    vec2 from; // barycentrics
    vec2 to;
    uint triangle;
    uint steps; // from the walk's start, and what kind of arc
};

const uint ARC_ROUND = 0x80000000u;   // of an ellipse
const uint ARC_PIERCED = 0x40000000u; // `from` is on the line PL
const uint ARC_POINT = 0x20000000u;   // `from` alone, and it is a zero
const uint ARC_STEPS = 0x1fffffffu;

// Group counts of an indirect dispatch and the number of walks that it is for, a round of walking each.
struct Round {
    uint groups_x;
    uint groups_y;
    uint groups_z;
    uint walks;
};

layout(set = 3, binding = 3, std430) buffer Walks { Walk walks[]; };
layout(set = 3, binding = 4, std430) buffer Rounds { Round rounds[]; };
layout(set = 3, binding = 5, std430) buffer WalkLists { uint walk_lists[]; }; // two, for even and odd rounds
layout(set = 3, binding = 6, std430) buffer Brackets { Bracket brackets[]; };  // MAX_BRACKETS a pixel layer
layout(set = 3, binding = 7, std430) buffer BracketCounts { uint bracket_counts[]; }; // and CERTAIN

// In a layer's count of arcs: on one of them the objective changes its sign.
const uint CERTAIN = 0x80000000u;

// Puts `walk` into a round's list at `place`, and sees to it that there is a workgroup for it.
void list_walk(uint round, uint place, uint walk, uint capacity) {
    walk_lists[(round & 1u) * capacity + place] = walk;
    if (place % 64u == 0u) {
        atomicAdd(rounds[round].groups_x, 1u);
        rounds[round].groups_y = 1u;
        rounds[round].groups_z = 1u;
    }
}

// Where a walk that leaves a triangle at the crossing `exit` enters the next, which is `across` that edge. At a corner it
// stays on the edge.
float entry_across(uint across, float exit) {
    return float(across % 4u) + min(1.0 - fract(exit), LAST_PLACE);
}

void append_bracket(uint item, Bracket bracket, bool certain) {
    uint place = atomicAdd(bracket_counts[item], 1u) & ~CERTAIN;
    if (certain) atomicOr(bracket_counts[item], CERTAIN);
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

Arc arc_of(Facet facet, Bracket bracket) {
    bool pierced = (bracket.steps & ARC_PIERCED) != 0u;
    if ((bracket.steps & ARC_ROUND) != 0u) return Arc(bracket.from, bracket.to, true, pierced, vec2(0.0), 0.0);
    return arc_between(facet, bracket.from, bracket.to, pierced);
}

// An ellipse inside a triangle, in quarters: between one look and the next the objective turns less.
void append_round(uint item, uint triangle, vec2 from, bool pierced) {
    for (uint i = 0u; i < 4u; i++) {
        uint kind = ARC_ROUND | (pierced ? ARC_PIERCED : 0u);
        append_bracket(item, Bracket(from, vec2(i, i + 1u) / 4.0, triangle, kind), false);
    }
}

// Hands on what is between the point where the line PL meets the triangle and a crossing, if it may hold a zero.
void append_pierced(Query query, uint item, Facet facet, uint triangle, vec2 from, vec2 to, uint steps) {
    // The other triangle at the crossing is pierced too, to within the margin, and has the rest.
    if (distance(from, to) < PIERCED_MARGIN) return;
    Bracket bracket = Bracket(from, to, triangle, steps | ARC_PIERCED);
    vec2 near;
    float before = objective_on(query, facet, arc_of(facet, bracket), 0.0, near);
    vec3 at = facet_point(facet, weights(to));
    vec3 normal = facet_normal(facet, weights(to));
    float after = objective_at(query, at, normal);
    vec3 at_near = facet_point(facet, weights(near));
    if (may_vanish(query, before, after, at_near, at, facet_normal(facet, weights(near)), normal)) {
        append_bracket(item, bracket, (before < 0.0) != (after < 0.0));
    }
}

// Hands on the point where the line PL meets the triangle, for Newton's method. Where the normal there is nearly along PL the
// root is near, and the curve no help in finding it: where the normal is along PL every plane through PL contains it.
void append_point(uint item, uint triangle, vec2 place, uint steps) {
    append_bracket(item, Bracket(place, place, triangle, steps | ARC_POINT), false);
}

// Hands on more than half of an ellipse, between two crossings, in quarters; in two parts where the line PL meets it.
void append_turn(uint item, Facet facet, uint triangle, vec2 from, vec2 to, bool pierced, vec2 place, uint steps) {
    float turn = turn_between(facet, from, to);
    turn += turn > 0.0 ? -1.0 : 1.0; // the longer way
    float ends[2] = float[2](turn, 0.0);
    if (pierced) {
        ends[0] = turn_between(facet, place, to);
        ends[1] = turn_between(facet, place, from);
        if (ends[0] * turn < 0.0) ends[0] += sign(turn);
        if (ends[1] * turn > 0.0) ends[1] -= sign(turn);
        append_point(item, triangle, place, steps);
    }
    uint kind = ARC_ROUND | (pierced ? ARC_PIERCED : 0u);
    for (uint i = 0u; i < 8u; i++) {
        float end = ends[i / 4u];
        if (end == 0.0) continue;
        vec2 parts = end * vec2(i % 4u, i % 4u + 1u) / 4.0;
        append_bracket(item, Bracket(pierced ? place : from, parts, triangle, steps | kind), false);
    }
}

// Hands on the arc between two crossings, if it may hold a zero; in two parts where the line PL meets it.
void append_arc(Query query, uint item, Facet facet, uint triangle, vec2 from, vec2 to, uint crossings, uint steps) {
    vec2 pierced;
    Arc arc = arc_between(facet, from, to, false);
    bool is_on_line = is_pierced(facet, pierced) && on_arc(facet, arc, pierced, crossings);
    if (is_longer_way(facet, arc)) {
        append_turn(item, facet, triangle, from, to, is_on_line, pierced, steps);
        return;
    }
    if (is_on_line) {
        append_point(item, triangle, pierced, steps);
        append_pierced(query, item, facet, triangle, pierced, from, steps);
        append_pierced(query, item, facet, triangle, pierced, to, steps);
        return;
    }
    vec3 at_from = facet_point(facet, weights(from));
    vec3 at_to = facet_point(facet, weights(to));
    vec3 normal_from = facet_normal(facet, weights(from));
    vec3 normal_to = facet_normal(facet, weights(to));
    float before = objective_at(query, at_from, normal_from);
    float after = objective_at(query, at_to, normal_to);
    if (may_vanish(query, before, after, at_from, at_to, normal_from, normal_to)) {
        append_bracket(item, Bracket(from, to, triangle, steps), (before < 0.0) != (after < 0.0));
    }
}
