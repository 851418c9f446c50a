// The coplanarity constraint on one triangle (Granizo-Hidalgo and Holzschuch 2024, Section 3.3): P->L, P->M and the
// interpolated normal in one plane. Products of linear functions of the barycentrics, so a conic; here in Bernstein form,
// whose six coefficients are triple products at corners and edges. An edge's crossings then depend on that edge's two
// corners alone, and both its triangles find the same (in the form of the paper's Eqs. 22-24 two of three have wrong
// coefficients).
#include "shared/surface.glsl"
#include "technique/mnee/surface.glsl"

// A receiver and a light. Positions are relative to the receiver: differences of large coordinates are taken once.
struct Query {
    vec3 point;       // P, world space
    vec3 light;       // L - P; of a directional light the unit direction towards it
    bool directional;
    float point_index; // refractive index around P
    float light_index; // and around L
};

struct Facet {
    vec3 at[3];     // corners - P
    vec3 normal[3];
    float corner[3]; // the constraint at the corners
    float edge[3];   // its mixed coefficients on the edges 01, 12, 20
    vec3 pierced;    // weights, not normalised, of where the line PL meets the triangle's plane
};

Facet facet_at(Query query, uvec3 corners) {
    Facet facet;
    vec3 across[3]; // normals of the plane through P, L and the corner, not of unit length
    for (uint i = 0u; i < 3u; i++) {
        SpecularVertex vertex = specular_vertices[corners[i]];
        facet.at[i] = vertex.position - query.point;
        facet.normal[i] = vertex.normal;
        across[i] = cross(query.light, facet.at[i]);
        facet.corner[i] = dot(facet.normal[i], across[i]);
    }
    for (uint i = 0u; i < 3u; i++) {
        uint next = i == 2u ? 0u : i + 1u;
        facet.edge[i] = 0.5 * (dot(facet.normal[i], across[next]) + dot(facet.normal[next], across[i]));
    }
    facet.pierced = vec3(dot(facet.at[2], across[1]), dot(facet.at[0], across[2]), dot(facet.at[1], across[0]));
    return facet;
}

// How far outside of a triangle, in barycentrics, the line PL still counts as meeting it. A crossing so near to the line
// is on either side of it by rounding alone; this way both triangles there take the line's own point instead.
const float PIERCED_MARGIN = 1e-3;

// Whether the line through P and L meets the triangle, and where. The curve goes through there, and the plane of P, L and M
// is undefined there.
bool is_pierced(Facet facet, out vec2 place) {
    float sum = facet.pierced.x + facet.pierced.y + facet.pierced.z;
    place = facet.pierced.yz / (abs(sum) > 1e-37 ? sum : 1e-37);
    return min(min(place.x, place.y), 1.0 - place.x - place.y) > -PIERCED_MARGIN;
}

vec3 facet_point(Facet facet, vec3 weight) {
    return facet.at[0] * weight.x + facet.at[1] * weight.y + facet.at[2] * weight.z;
}

vec3 facet_normal(Facet facet, vec3 weight) {
    return facet.normal[0] * weight.x + facet.normal[1] * weight.y + facet.normal[2] * weight.z;
}

// Barycentrics as weights of the three corners.
vec3 weights(vec2 barycentrics) {
    return vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
}

// From the point with barycentrics `from` to that with `to`, without the rounding of either.
vec3 facet_step(Facet facet, vec2 from, vec2 to) {
    vec2 step = to - from;
    return (facet.at[1] - facet.at[0]) * step.x + (facet.at[2] - facet.at[0]) * step.y;
}

// Places on the boundary are written as edge + t, t from the edge's first corner to its second.
vec2 boundary_barycentrics(float place) {
    uint edge = min(uint(place), 2u);
    float t = place - float(edge);
    return edge == 0u ? vec2(t, 0.0) : edge == 1u ? vec2(1.0 - t, t) : vec2(0.0, 1.0 - t);
}

// The constraint, a quadratic form: half of its gradient at a point is form(point).
vec3 form(Facet facet, vec3 weight) {
    return vec3(
        facet.corner[0] * weight.x + facet.edge[0] * weight.y + facet.edge[2] * weight.z,
        facet.edge[0] * weight.x + facet.corner[1] * weight.y + facet.edge[1] * weight.z,
        facet.edge[2] * weight.x + facet.edge[1] * weight.y + facet.corner[2] * weight.z);
}

float constraint(Facet facet, vec3 weight) {
    return dot(weight, form(facet, weight));
}
