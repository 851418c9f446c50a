// The pieces of the coplanarity curve in one triangle: where they cross its boundary, which crossings belong to one piece,
// and points between.
#include "technique/mnee/facet.glsl"

// A crossing at a corner would belong to either of two edges; it stays this far from the edge's end, in parts of the edge.
const float LAST_PLACE = 0.999999;

// Places on the boundary where the constraint vanishes, in order round it.
struct Crossings {
    uint count; // even
    float place[6];
};

// The zeros in [0, 1] of a (1-t)^2 + 2 b t (1-t) + c t^2; with s = t / (1-t) they are those of c s^2 + 2 b s + a. Zero
// counts as positive at a corner, in every triangle that has the corner, so that no curve ends there.
uint edge_zeros(float a, float b, float c, out vec2 t) {
    t = vec2(0.0);
    bool changes = (a < 0.0) != (c < 0.0);
    if (c < 0.0) {
        a = -a;
        b = -b;
        c = -c;
    }
    float discriminant = b * b - a * c;
    if (changes) {
        float root = sqrt(max(discriminant, 0.0));
        float above = b > 0.0 ? -a : root - b;
        float below = b > 0.0 ? b + root : c;
        t.x = above / max(above + below, 1e-37);
        return 1u;
    }
    if (b >= 0.0 || discriminant <= 0.0) return 0u;
    float larger = sqrt(discriminant) - b;
    t = vec2(a / (a + larger), larger / (larger + c));
    return 2u;
}

Crossings crossings_of(Facet facet) {
    Crossings result;
    result.count = 0u;
    for (uint i = 0u; i < 3u; i++) {
        vec2 t;
        uint zeros = edge_zeros(facet.corner[i], facet.edge[i], facet.corner[i == 2u ? 0u : i + 1u], t);
        t = clamp(t, 0.0, LAST_PLACE);
        if (zeros > 0u) result.place[result.count++] = float(i) + t.x;
        if (zeros > 1u) result.place[result.count++] = float(i) + t.y;
    }
    return result;
}

// The middle of the boundary from place `from` on to the next crossing.
vec3 middle_of_interval(float from, float to) {
    float place = from + 0.5 * (to > from ? to - from : to - from + 3.0);
    return weights(boundary_barycentrics(place < 3.0 ? place : place - 3.0));
}

// Whether the constraint keeps its sign on the segment between two weights where it has one sign. Both lie in one of its
// convex regions then, if that sign is the convex regions' sign.
bool same_region(Facet facet, vec3 u, vec3 v) {
    vec2 t;
    float a = constraint(facet, u);
    float b = dot(u, form(facet, v));
    float c = constraint(facet, v);
    return (a < 0.0) == (c < 0.0) && edge_zeros(a, b, c, t) == 0u;
}

// The crossing at the other end of the piece that has crossing `entry`.
//
// With more than two crossings the pieces have to be told apart. Where a conic is not degenerate, the sign of its
// determinant is the constraint's sign in its convex regions (inside an ellipse, inside the branches of a hyperbola). Two
// intervals of the boundary with that sign belong to one convex region exactly if the segment between them does not
// leave it; a piece runs from one interval of its region to the region's next.
uint partner(Facet facet, Crossings crossings, uint entry) {
    uint count = crossings.count;
    if (count == 2u) return 1u - entry;
    mat3 q = mat3(
        facet.corner[0], facet.edge[0], facet.edge[2],
        facet.edge[0], facet.corner[1], facet.edge[1],
        facet.edge[2], facet.edge[1], facet.corner[2]);
    bool convex_negative = determinant(q) < 0.0;
    uint next = entry + 1u == count ? 0u : entry + 1u;
    vec3 after = middle_of_interval(crossings.place[entry], crossings.place[next]);
    // Interval i runs from crossing i to the next. Away from the convex interval that `entry` bounds, step by step.
    bool own_after = (constraint(facet, after) < 0.0) == convex_negative;
    uint before = entry == 0u ? count - 1u : entry - 1u;
    vec3 own = own_after ? after : middle_of_interval(crossings.place[before], crossings.place[entry]);
    for (uint step = 1u; step < count; step += 2u) {
        // The crossing at the near end of the next convex interval, and the one at its far end.
        uint near_end = own_after ? (entry + count - step) % count : (entry + step) % count;
        uint far_end = own_after ? (near_end + count - 1u) % count : (near_end + 1u) % count;
        uint first = own_after ? far_end : near_end;
        uint second = own_after ? near_end : far_end;
        vec3 other = middle_of_interval(crossings.place[first], crossings.place[second]);
        if (step + 1u < count && same_region(facet, own, other)) return near_end;
    }
    // No other interval is in the region: the piece cuts off its own interval.
    return own_after ? next : before;
}

// A piece of the curve: from one of its points to another; or, of an ellipse inside the triangle, what is between two
// parts of the way round from a point.
struct Arc {
    vec2 from; // barycentrics
    vec2 to;   // or the first and the last part of the way round
    bool round;
    bool pierced; // whether `from` is on the line PL
    vec2 across;  // direction from the chord to the curve
    float side;   // of the chord along `across` that the curve is on; 0 where it is all but straight
};

// Of the constraint as c + 2 g.x + x.H.x in barycentrics x: where the gradient vanishes, and H's three numbers.
vec2 centre_of(Facet facet, out vec3 bend) {
    float c = facet.corner[0];
    bend = vec3(c - 2.0 * facet.edge[0] + facet.corner[1],
                c - facet.edge[0] - facet.edge[2] + facet.edge[1],
                c - 2.0 * facet.edge[2] + facet.corner[2]);
    vec2 gradient = vec2(facet.edge[0] - c, facet.edge[2] - c);
    float determinant = bend.x * bend.z - bend.y * bend.y;
    if (abs(determinant) < 1e-37) return vec2(-1.0);
    return vec2(bend.y * gradient.y - bend.z * gradient.x, bend.y * gradient.x - bend.x * gradient.y) / determinant;
}

// Whether an ellipse lies inside the triangle whose boundary the curve does not cross, and a point of it.
bool ellipse_inside(Facet facet, out vec2 place) {
    vec3 bend;
    vec2 centre = centre_of(facet, bend);
    place = centre;
    float level = constraint(facet, weights(centre));
    bool inside = min(min(centre.x, centre.y), 1.0 - centre.x - centre.y) > 0.0;
    float curvature = bend.x;
    if (!inside || (level < 0.0) == (facet.corner[0] < 0.0) || level * curvature >= 0.0) return false;
    place = centre + vec2(sqrt(-level / curvature), 0.0);
    return true;
}

// Sine of the angle between arc and chord at the arc's end, and part of a chord that it may be off, below which rounding
// could have bent an arc to either side.
const float STRAIGHT_ARC = 1e-3;

// Sine of the angle to the chord that the direction across it has at least.
const float LEAST_ACROSS = 0.02;

// An arc that ends at a crossing.
//
// Points on it are found across the chord along its conjugate direction, that of the line through the middles of parallel
// chords. A line in that direction meets each branch of a hyperbola once, however sharply it turns, and half of an ellipse
// once. Where the arc is nearly straight the conjugate direction tends to the chord's own, and at right angles does as well.
Arc arc_between(Facet facet, vec2 from, vec2 to, bool pierced) {
    Arc arc = Arc(from, to, false, pierced, vec2(0.0), 0.0);
    vec2 chord = to - from;
    float length2 = dot(chord, chord);
    vec3 bend;
    centre_of(facet, bend);
    vec2 normal = vec2(bend.x * chord.x + bend.y * chord.y, bend.y * chord.x + bend.z * chord.y);
    float along = dot(normal, chord);
    bool transverse = along * along > LEAST_ACROSS * LEAST_ACROSS * dot(normal, normal) * length2;
    vec2 direction = transverse ? vec2(-normal.y, normal.x) * sign(along) : vec2(-chord.y, chord.x);
    arc.across = direction * sqrt(length2 / max(dot(direction, direction), 1e-37));

    // The curve comes to the crossing from inside the triangle, and being convex it stays on one side of the chord.
    vec3 weight = weights(to);
    vec3 gradient = form(facet, weight);
    vec2 tangent = vec2(gradient.x - gradient.z, gradient.y - gradient.x);
    float least = min(min(weight.x, weight.y), weight.z);
    float inward = least == weight.x ? -tangent.x - tangent.y : least == weight.y ? tangent.x : tangent.y;
    float turn = chord.x * tangent.y - chord.y * tangent.x;
    if (turn * turn > STRAIGHT_ARC * STRAIGHT_ARC * length2 * dot(tangent, tangent)) {
        arc.side = (inward < 0.0) == (turn < 0.0) ? 1.0 : -1.0;
    }
    return arc;
}

// The zeros of c0 + c1 s + c2 s^2, the nearer to 0 first.
vec2 zeros_of(float c0, float c1, float c2) {
    float root = sqrt(max(c1 * c1 - 4.0 * c0 * c2, 0.0));
    float q = -0.5 * (c1 < 0.0 ? c1 - root : c1 + root);
    return vec2(abs(q) > 1e-37 ? c0 / q : 0.0, abs(c2) > 1e-37 ? q / c2 : 1e30);
}

// How far an arc may be from its chord, in chords. Four are an ellipse eight times as long as wide.
const float MAX_BULGE = 4.0;

// Barycentrics of the arc's point at `part` in [0, 1].
vec2 arc_point(Facet facet, Arc arc, float part) {
    if (arc.round) {
        vec3 bend;
        vec2 centre = centre_of(facet, bend);
        vec2 spoke = arc.from - centre;
        float angle = 2.0 * PI * mix(arc.to.x, arc.to.y, part);
        vec2 turned = cos(angle) * spoke + sin(angle) * vec2(-spoke.y, spoke.x);
        float level = constraint(facet, weights(centre));
        float curvature = dot(turned, vec2(bend.x * turned.x + bend.y * turned.y, bend.y * turned.x + bend.z * turned.y));
        return centre + turned * (level * curvature < 0.0 ? sqrt(-level / curvature) : 1.0);
    }
    vec2 base_place = mix(arc.from, arc.to, part);
    vec3 base = weights(base_place);
    vec3 step = vec3(-arc.across.x - arc.across.y, arc.across);
    vec3 gradient = form(facet, step);
    // Both ends are on the curve: of the constraint on the chord only this is left, without what rounding makes of the rest.
    vec3 chord = weights(arc.to) - weights(arc.from);
    float level = -part * (1.0 - part) * dot(chord, form(facet, chord));
    vec2 zeros = zeros_of(level, 2.0 * dot(base, gradient), dot(step, gradient));
    zeros = clamp(zeros, -MAX_BULGE, MAX_BULGE);
    // More than half of an ellipse is on the far side.
    vec2 far = base_place + arc.across * zeros.y;
    bool far_inside = min(min(far.x, far.y), 1.0 - far.x - far.y) > 0.0;
    bool other = zeros.x * arc.side < -STRAIGHT_ARC && zeros.y * arc.side > 0.0 && far_inside;
    return other ? far : base_place + arc.across * zeros.x;
}

// Whether a point of the curve inside the triangle is on an arc between two crossings, given how many crossings there are:
// it is on the boundary of the arc's convex region, and on the arc's side of the chord.
bool on_arc(Facet facet, Arc arc, vec2 place, uint crossings) {
    if (crossings == 2u) return true;
    vec2 middle = 0.5 * (arc.from + arc.to);
    if (!same_region(facet, weights(middle), weights(mix(place, middle, 0.05)))) return false;
    vec2 chord = arc.to - arc.from;
    vec2 way = place - arc.from;
    return (chord.x * way.y - chord.y * way.x) * arc.side >= 0.0;
}

// Whether an arc is more than half of an ellipse: the centre is on its side of the chord.
bool is_longer_way(Facet facet, Arc arc) {
    vec3 bend;
    vec2 centre = centre_of(facet, bend);
    vec2 chord = arc.to - arc.from;
    vec2 way = centre - arc.from;
    return bend.x * bend.z > bend.y * bend.y && (chord.x * way.y - chord.y * way.x) * arc.side > 0.0;
}

// The part of a turn round an ellipse's centre, in the plane of barycentrics, that leads from one point of it to another; in
// [-1/2, 1/2].
float turn_between(Facet facet, vec2 from, vec2 to) {
    vec3 bend;
    vec2 centre = centre_of(facet, bend);
    vec2 a = from - centre;
    vec2 b = to - centre;
    return atan(a.x * b.y - a.y * b.x, dot(a, b)) / (2.0 * PI);
}
