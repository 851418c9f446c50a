// Where a ray is inside a beam. With y = y0 + t yd along the ray, the corners of the cross-section through it, seen from it,
// are linear in t, so the numerators of its barycentrics are quadratics of t: their roots are where the ray crosses the
// bilinear sides. The sides are shared with the neighbours, so that no seam shows.
#include "technique/beams/section.glsl"

struct Crossing {
    float centre; // m along the ray, the middle of the beam; t counts from here, which keeps the quadratics exact where
                  // the beam is narrow and far away (erratum 8)
    vec2 height;  // y = height.x + t height.y
    // Numerators of the three barycentrics, twice areas in m2: constant + t (linear + t square).
    vec3 constant;
    vec3 linear;
    vec3 square;
    // Their sum, from the beam alone.
    vec3 area;
};

Crossing crossing_of(Beam beam, vec3 origin, vec3 direction, float length) {
    Crossing c;
    vec3 at[3], slope[3], side[3], turn[3];
    float rise = dot(beam.normal, direction);
    vec3 from = origin - beam.corners[0].origin;
    float y = dot(beam.normal, from);
    vec3 middle = vec3(0.0);
    vec3 drift = vec3(0.0);
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner corner = beam.corners[i];
        middle += corner.origin - beam.corners[0].origin + y * corner.way - from;
        slope[i] = rise * corner.way - direction;
        drift += slope[i];
    }
    c.centre = clamp(-dot(middle, drift) / max(dot(drift, drift), 1e-20), 0.0, length);
    from = origin + c.centre * direction - beam.corners[0].origin;
    c.height = vec2(dot(beam.normal, from), rise);
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner a = beam.corners[i];
        BeamCorner b = beam.corners[(i + 1u) % 3u];
        at[i] = a.origin - beam.corners[0].origin + c.height.x * a.way - from;
        side[i] = b.origin - a.origin + c.height.x * (b.way - a.way);
        turn[i] = rise * (b.way - a.way);
    }
    for (uint i = 0u; i < 3u; i++) {
        uint j = (i + 1u) % 3u;
        c.constant[i] = dot(beam.normal, cross(at[j], side[j]));
        c.linear[i] = dot(beam.normal, cross(at[j], turn[j]) + cross(slope[j], side[j]));
        c.square[i] = dot(beam.normal, cross(slope[j], turn[j]));
    }
    c.area = vec3(dot(beam.normal, cross(side[0], side[1])),
                  dot(beam.normal, cross(side[0], turn[1]) + cross(turn[0], side[1])),
                  dot(beam.normal, cross(turn[0], turn[1])));
    return c;
}

vec3 numerators(Crossing c, float t) {
    return c.constant + t * (c.linear + t * c.square);
}

float twice_area(Crossing c, float t) {
    return c.area.x + t * (c.area.y + t * c.area.z);
}

// Whether all barycentrics of a place on the ray are positive.
bool has_one_sign(Crossing c, float t) {
    vec3 parts = numerators(c, t);
    float low = min(parts.x, min(parts.y, parts.z));
    float high = max(parts.x, max(parts.y, parts.z));
    return low >= 0.0 ? high > 0.0 : high <= 0.0;
}

// Whether a place with positive barycentrics is near enough for that not to be noise.
bool is_within_beam(Beam beam, Crossing c, vec3 origin, vec3 direction, float t) {
    float y = c.height.x + t * c.height.y;
    vec3 sides[3];
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner a = beam.corners[i];
        BeamCorner b = beam.corners[(i + 1u) % 3u];
        sides[i] = b.origin - a.origin + y * (b.way - a.way);
    }
    vec3 to_corner = beam.corners[0].origin + y * beam.corners[0].way - origin - (c.centre + t) * direction;
    return is_within_reach(to_corner, sides);
}

// Real roots of constant + t (linear + t square), far away where there is none. The root of larger size comes first, and
// the other from their product: the plain formula cancels for nearly parallel edges (erratum 8).
vec2 roots(float constant, float linear, float square) {
    const float NONE = 3e38;
    float inner = linear * linear - 4.0 * square * constant;
    if (!(inner >= 0.0)) return vec2(NONE);
    float q = -0.5 * (linear + (linear < 0.0 ? -1.0 : 1.0) * sqrt(inner));
    vec2 found = vec2(abs(square) > 0.0 ? q / square : NONE, abs(q) > 0.0 ? constant / q : NONE);
    return vec2(abs(found.x) < NONE ? found.x : NONE, abs(found.y) < NONE ? found.y : NONE);
}

// Cuts the part to where a number that is `before` at t = 0 and rises by `slope` is not below 0.
void cut_below(float before, float slope, inout vec2 part) {
    float t = -before / slope;
    if (slope > 0.0) {
        part.x = max(part.x, t);
    } else if (slope < 0.0) {
        part.y = min(part.y, t);
    } else if (!(before >= 0.0)) {
        part.y = part.x;
    }
}

// Cuts the part at a plane through the three points, of which the side that the normal looks at is kept; across the
// beam at their mean where they are no plane across it.
void cut(Beam beam, vec3 a, vec3 b, vec3 c, vec3 at, vec3 direction, float keep, inout vec2 part) {
    vec3 normal = cross(b - a, c - a);
    float along = dot(normal, beam.normal);
    if (!(abs(along) > 1e-3 * length(normal))) {
        normal = beam.normal;
        a = (a + b + c) / 3.0;
    }
    if (dot(normal, beam.normal) * keep < 0.0) normal = -normal;
    cut_below(dot(normal, at - a), dot(normal, direction), part);
}

// The part of the ray between where the beam starts and where it ends, t.
vec2 part_between_ends(Beam beam, Crossing c, vec3 origin, vec3 direction, float length) {
    vec2 part = vec2(0.0, length) - c.centre;
    vec3 at = origin + c.centre * direction;
    vec3 starts[3], ends[3];
    vec3 last = beam_ends(beam);
    // One that ends on different surfaces is followed to the last of them, and a ray tells what is lit.
    if ((beam.flags & BEAM_STRADDLES) != 0u) last = vec3(max(last.x, max(last.y, last.z)));
    for (uint i = 0u; i < 3u; i++) {
        starts[i] = beam.corners[i].origin + beam.corners[i].start * beam.corners[i].way;
        ends[i] = beam.corners[i].origin + last[i] * beam.corners[i].way;
    }
    // A steep plane through the starts does not keep what is before all of them.
    vec3 first = beam_starts(beam);
    cut_below(c.height.x - min(first.x, min(first.y, first.z)), c.height.y, part);
    cut_below(max(last.x, max(last.y, last.z)) - c.height.x, -c.height.y, part);
    cut(beam, starts[0], starts[1], starts[2], at, direction, 1.0, part);
    cut(beam, ends[0], ends[1], ends[2], at, direction, -1.0, part);
    return part;
}

// Six crossings part a ray into seven pieces at most.
const uint MOST_PIECES = 7u;

// Where the ray crosses the sides' surfaces, two places a side.
struct SideCrossings {
    vec3 first;
    vec3 second;
};

SideCrossings side_crossings(Crossing c) {
    SideCrossings sides;
    for (uint i = 0u; i < 3u; i++) {
        vec2 found = roots(c.constant[i], c.linear[i], c.square[i]);
        sides.first[i] = found.x;
        sides.second[i] = found.y;
    }
    return sides;
}

// The first of them after t.
float next_side(SideCrossings sides, float t) {
    vec3 next = min(mix(sides.first, vec3(3e38), lessThanEqual(sides.first, vec3(t))),
                    mix(sides.second, vec3(3e38), lessThanEqual(sides.second, vec3(t))));
    return min(next.x, min(next.y, next.z));
}

// False only for rays that pass a beam by. A ray that meets the beam meets a line of light in it, which is
// a mean of the edges in place and in direction. So the ray's sides of the edges, as triple products, have a mean of 0 but
// for a third of what the edges' differences make of it at most.
bool may_meet(Beam beam, vec3 origin, vec3 direction, float length) {
    vec2 range = beam_range(beam);
    float from = dot(beam.normal, origin - beam.corners[0].origin);
    float to = from + length * dot(beam.normal, direction);
    if (max(from, to) < range.x || min(from, to) > range.y) return false;
    vec3 sides, spreads;
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner a = beam.corners[i];
        BeamCorner b = beam.corners[(i + 1u) % 3u];
        sides[i] = dot(cross(direction, a.way), a.origin - origin);
        spreads[i] = abs(dot(cross(direction, a.way - b.way), a.origin - b.origin));
    }
    float spread = max(spreads.x, max(spreads.y, spreads.z)) / 3.0;
    float low = min(sides.x, min(sides.y, sides.z));
    float high = max(sides.x, max(sides.y, sides.z));
    spread += 1e-5 * max(abs(low), abs(high));
    return low <= spread && high >= -spread;
}

// The first part of the ray from `from` on whose barycentrics are positive; nothing of it where there is none. Between
// crossings all are as they are in the middle.
vec2 next_inside(Crossing c, vec2 part, float from) {
    SideCrossings sides = side_crossings(c);
    vec2 found = vec2(part.y);
    float start = max(part.x, from);
    for (uint piece = 0u; piece < MOST_PIECES; piece++) {
        float end = min(next_side(sides, start), part.y);
        bool first = found.x >= part.y && start < end && has_one_sign(c, 0.5 * (start + end));
        if (first) found = vec2(start, end);
        start = end;
    }
    return found;
}

// The paper's interval (section 5.1, after Ernst et al. 2005): a plane through the ray, as nearly parallel to the beam's
// planes as can be, meets the edges in a triangle; the ray inside it. The plane cuts the sides in curves, not lines, so
// neighbours overlap or leave gaps a little.
vec2 scan_plane_part(Beam beam, Crossing c, vec3 origin, vec3 direction, vec2 part) {
    vec3 across = cross(direction, beam.normal);
    vec3 normal = cross(direction, across);
    vec3 at = origin + c.centre * direction;
    vec2 corners[3]; // along the ray, and across
    for (uint i = 0u; i < 3u; i++) {
        float rise = dot(normal, beam.corners[i].way);
        vec3 from = beam.corners[i].origin - at;
        if (rise == 0.0) return vec2(0.0);
        vec3 met = from - dot(normal, from) / rise * beam.corners[i].way;
        corners[i] = vec2(dot(met, direction), dot(met, across));
    }
    float low = 3e38;
    float high = -3e38;
    for (uint i = 0u; i < 3u; i++) {
        vec2 a = corners[i];
        vec2 b = corners[(i + 1u) % 3u];
        if ((a.y < 0.0) == (b.y < 0.0)) continue;
        float t = mix(a.x, b.x, a.y / (a.y - b.y));
        low = min(low, t);
        high = max(high, t);
    }
    return vec2(max(low, part.x), min(high, part.y));
}
