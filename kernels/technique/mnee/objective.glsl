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

// Unit normal of the plane through P, L and M. It turns round where M passes the line PL; elsewhere it is continuous.
vec3 plane_normal(Query query, vec3 at) {
    vec3 normal = cross(query.light, at);
    return normal * inversesqrt(max(dot(normal, normal), 1e-37));
}

// The plane's normal on the side of `like`; `like` itself where M is on the line PL to rounding.
vec3 plane_like(Query query, vec3 at, vec3 like) {
    vec3 normal = cross(query.light, at);
    float size2 = dot(normal, normal);
    if (size2 < 1e-9 * dot(query.light, query.light) * dot(at, at)) return like;
    return normal * (dot(normal, like) < 0.0 ? -inversesqrt(size2) : inversesqrt(size2));
}

// The sine that tells the half vector from the surface's normal, times the half vector's length: on the curve both lie in
// the plane with normal `plane`, so that one signed number says it all. (The sign of the paper's Eq. 20, by the curve's
// tangent, is zero all along the curve of a flat surface.)
float objective(Query query, vec3 at, vec3 normal, vec3 plane) {
    return dot(cross(normalize(normal), half_vector(query, at)), plane);
}
