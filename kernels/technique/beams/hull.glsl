// What a rasteriser draws in a beam's place: a convex volume of two triangles across the beam, before its start and beyond
// its end, and six round it. Edge by edge of both triangles, the side that touches the other triangle at its corner
// farthest out is one of the six (Liktor and Dachsbacher 2011, section 4.3). Where two corners are as far out, and their
// rounding could open the volume, the end's triangle is widened until its edges are parallel to the start's, which makes
// the sides those of a prism cut off by its ends (Ernst et al. 2005).
#include "shared/view.glsl"
#include "technique/beams/section.glsl"

const uint HULL_VERTICES = 24u;
const uint HULL_NONE = 1u << 31;

struct Hull {
    vec3 corner0; // of the start's triangle
    uint faces;   // two bits an edge: the other triangle's corner; then a bit a face: turned round
    vec3 corner1;
    uint padding0;
    vec3 corner2;
    uint padding1;
    vec3 corner3; // of the end's
    uint padding2;
    vec3 corner4;
    uint padding3;
    vec3 corner5;
    uint padding4;
};

// Pixels by which all of it is widened: rasterisers know positions to a sixteenth of a pixel at worst.
const float MARGIN = 0.125;
// Of a triangle's size: corners no more apart than this count as equally far out.
const float TIE = 1e-3;

float cross2(vec2 a, vec2 b) {
    return a.x * b.y - a.y * b.x;
}

// Moves the sides outwards by `margin`; of a triangle too thin for that, takes a regular one round it.
void widen(inout vec2 t[3], float margin) {
    vec3 sides = vec3(distance(t[1], t[2]), distance(t[2], t[0]), distance(t[0], t[1]));
    float round_it = sides.x + sides.y + sides.z;
    float inner = abs(cross2(t[1] - t[0], t[2] - t[0])) / max(round_it, 1e-30);
    if (inner > 2.0 * margin) {
        vec2 middle = (sides.x * t[0] + sides.y * t[1] + sides.z * t[2]) / round_it;
        for (uint i = 0u; i < 3u; i++) t[i] = middle + (1.0 + margin / inner) * (t[i] - middle);
        return;
    }
    vec2 middle = (t[0] + t[1] + t[2]) / 3.0;
    float reach = margin;
    for (uint i = 0u; i < 3u; i++) reach = max(reach, distance(t[i], middle) + margin);
    t[0] = middle + reach * vec2(0.0, 2.0);
    t[1] = middle + reach * vec2(-1.7320508, -1.0);
    t[2] = middle + reach * vec2(1.7320508, -1.0);
}

// The corner of `other` farthest out over the edge from t[edge] on, and whether another is about as far.
uint farthest(vec2 t[3], vec2 other[3], uint edge, out bool tie) {
    vec2 side = t[(edge + 1u) % 3u] - t[edge];
    vec2 outward = vec2(side.y, -side.x) * (cross2(side, t[(edge + 2u) % 3u] - t[edge]) < 0.0 ? -1.0 : 1.0);
    vec3 out_by = vec3(dot(outward, other[0]), dot(outward, other[1]), dot(outward, other[2]));
    uint best = out_by.y > out_by.x ? 1u : 0u;
    if (out_by.z > out_by[best]) best = 2u;
    float second = max(out_by[(best + 1u) % 3u], out_by[(best + 2u) % 3u]);
    float least = min(out_by.x, min(out_by.y, out_by.z));
    tie = out_by[best] - second <= TIE * (out_by[best] - least);
    return best;
}

// The smallest triangle round `other` with sides parallel to those of t.
void circumscribe(vec2 t[3], inout vec2 other[3]) {
    vec2 normal[3];
    float reach[3];
    for (uint i = 0u; i < 3u; i++) {
        vec2 side = t[(i + 1u) % 3u] - t[i];
        normal[i] = vec2(side.y, -side.x) * (cross2(side, t[(i + 2u) % 3u] - t[i]) < 0.0 ? -1.0 : 1.0);
        reach[i] = max(dot(normal[i], other[0]), max(dot(normal[i], other[1]), dot(normal[i], other[2])));
    }
    for (uint i = 0u; i < 3u; i++) {
        // Corner i lies between the side that ends and the one that begins there.
        uint before = (i + 2u) % 3u;
        float d = cross2(normal[before], normal[i]);
        other[i] = vec2(reach[before] * normal[i].y - reach[i] * normal[before].y,
                        reach[i] * normal[before].x - reach[before] * normal[i].x) / d;
    }
}

// Which three corners face `face` has: three over the start's edges, three over the end's, and the two triangles.
uvec3 hull_face(uint faces, uint face) {
    uint opposite = (faces >> (2u * face)) & 3u;
    if (face < 3u) return uvec3(face, (face + 1u) % 3u, 3u + opposite);
    if (face < 6u) return uvec3(face, 3u + (face - 2u) % 3u, opposite);
    return face == 6u ? uvec3(0u, 1u, 2u) : uvec3(3u, 4u, 5u);
}

vec3 hull_corner(Hull hull, uint corner) {
    switch (corner) {
    case 0u: return hull.corner0;
    case 1u: return hull.corner1;
    case 2u: return hull.corner2;
    case 3u: return hull.corner3;
    case 4u: return hull.corner4;
    }
    return hull.corner5;
}

// The corner of vertex 0 to 23, so that faces turn counter-clockwise seen from outside.
vec3 hull_vertex(Hull hull, uint vertex) {
    uint face = vertex / 3u;
    uvec3 corners = hull_face(hull.faces, face);
    uint at = vertex % 3u;
    if (((hull.faces >> (12u + face)) & 1u) != 0u && at > 0u) at = 3u - at;
    return hull_corner(hull, corners[at]);
}

Hull hull_of(Beam beam, bool prism) {
    Hull hull = Hull(vec3(0.0), HULL_NONE, vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), 0u, vec3(0.0), 0u);
    if ((beam.flags & BEAM_EMPTY) != 0u || !beam_is_finite(beam)) return hull;
    vec3 u, v;
    basis(beam.normal, u, v);
    vec3 origin = beam.corners[0].origin;
    vec2 range = beam_range(beam);
    vec2 ends[2][3];
    float margins[2];
    for (uint end = 0u; end < 2u; end++) {
        float far = 0.0;
        float large = 0.0;
        for (uint i = 0u; i < 3u; i++) {
            vec3 corner = beam.corners[i].origin + range[end] * beam.corners[i].way;
            far = max(far, distance(corner, view.position));
            large = max(large, max(abs(corner.x), max(abs(corner.y), abs(corner.z))));
            ends[end][i] = vec2(dot(corner - origin, u), dot(corner - origin, v));
        }
        // And what rounding moves corners by.
        margins[end] = MARGIN * view.pixel_angle * far + 4e-6 * large;
        widen(ends[end], margins[end]);
    }
    range += vec2(-margins[0], margins[1]);
    uint sides = 0u;
    bool any_tie = prism;
    for (uint edge = 0u; edge < 3u; edge++) {
        bool tie;
        sides |= farthest(ends[0], ends[1], edge, tie) << (2u * edge);
        any_tie = any_tie || tie;
        sides |= farthest(ends[1], ends[0], edge, tie) << (6u + 2u * edge);
        any_tie = any_tie || tie;
    }
    if (any_tie) {
        circumscribe(ends[0], ends[1]);
        sides = 0u;
        for (uint edge = 0u; edge < 3u; edge++) sides |= edge << (2u * edge) | ((edge + 1u) % 3u) << (6u + 2u * edge);
    }
    vec3 corners[6];
    vec3 middle = vec3(0.0);
    for (uint i = 0u; i < 6u; i++) {
        vec2 at = ends[i / 3u][i % 3u];
        corners[i] = origin + at.x * u + at.y * v + range[i / 3u] * beam.normal;
        middle += corners[i] / 6.0;
    }
    for (uint face = 0u; face < 8u; face++) {
        uvec3 of = hull_face(sides, face);
        vec3 outward = cross(corners[of.y] - corners[of.x], corners[of.z] - corners[of.x]);
        if (dot(outward, corners[of.x] - middle) < 0.0) sides |= 1u << (12u + face);
    }
    hull.faces = sides;
    hull.corner0 = corners[0];
    hull.corner1 = corners[1];
    hull.corner2 = corners[2];
    hull.corner3 = corners[3];
    hull.corner4 = corners[4];
    hull.corner5 = corners[5];
    return hull;
}
