// What vanishes where the curve carries a refracted path.
#include "technique/mnee/facet.glsl"

vec3 way_to_light(Query query, vec3 at) { // from M = P + at; not of unit length
    return query.directional ? query.light : query.light - at;
}

// The half vector of refraction (Walter et al. 2007), n_P w_P + n_L w_L with unit vectors from M to P and to L. By Snell's
// law it is parallel to the normal where light is refracted from L to P. Unlike the angle of the paper's Eq. 19 it
// exists at every M, also where light from the denser side would be reflected totally.
vec3 half_vector(Query query, vec3 at) {
    return query.light_index * normalize(way_to_light(query, at)) - query.point_index * normalize(at);
}

// Unit normal of the plane through P, L and M. `step` leads to M from P or, more exactly near there, from where the line PL
// meets the surface. At that point the plane is undefined, and the normal turns round as the curve passes it.
vec3 plane_normal(Query query, vec3 step) {
    vec3 normal = cross(query.light, step);
    return normal * inversesqrt(max(dot(normal, normal), 1e-37));
}

// The sine that tells the half vector from the surface's normal, times the half vector's length: on the curve both lie in
// the plane with normal `plane`, so that one signed number says it all. (The sign of the paper's Eq. 20, by the curve's
// tangent, is zero all along the curve of a flat surface.)
float objective(Query query, vec3 at, vec3 normal, vec3 plane) {
    return dot(cross(normalize(normal), half_vector(query, at)), plane);
}

// The objective at a crossing of a triangle's boundary, or wherever the curve is well away from the line PL.
float objective_at(Query query, vec3 at, vec3 normal) {
    return objective(query, at, normal, plane_normal(query, at));
}
