// The light that a refracted path carries.
#include "shared/optics.glsl"
#include "shared/visible.glsl"
#include "technique/mnee/objective.glsl"
#include "technique/mnee/counters.glsl"

struct Path {
    vec3 at;          // M - P
    vec3 geometric;   // unit normal of the triangle, front side
    vec3 to_light;    // unit, from M
    float light_distance;
    float point_distance;
    float reach;      // largest coordinate of the triangle's corners, m: what its rounding goes by
    vec3 irradiance;  // at P, W/m2, as if nothing were in the way
    uint rejected;    // 0, or the counter of the reason
};

// Derivatives of a ray from the light along one of two directions across it, carried to the plane through P across the
// path. Granizo-Hidalgo and Holzschuch's Eqs. 28-32, from the light's side, with unit vectors along the light's travel.
//
// What belongs to irradiance at P is the area there over the solid angle at L (Eq. 25 has the reverse, which lacks the
// squared ratio of the indices), and n' is the derivative of the normalised normal.
vec3 carried(vec3 across, bool directional, float light_distance, float point_distance, vec3 incident, vec3 refracted,
             vec3 geometric, vec3 normal, float eta, float cos_in, float cos_out, mat2x3 dual, mat2x3 normal_steps) {
    vec3 turn = directional ? vec3(0.0) : across;
    vec3 moved = (directional ? across : light_distance * across);
    moved -= dot(moved, geometric) / dot(incident, geometric) * incident;
    vec3 turned = normal_steps[0] * dot(moved, dual[0]) + normal_steps[1] * dot(moved, dual[1]);
    turned -= dot(turned, normal) * normal;
    float cos_in_turn = -dot(turn, normal) - dot(incident, turned);
    float slope = eta - eta * eta * cos_in / cos_out;
    vec3 refracted_turn = eta * turn + slope * cos_in_turn * normal + (eta * cos_in - cos_out) * turned;
    vec3 landed = moved + point_distance * refracted_turn;
    return landed - dot(landed, refracted) * refracted;
}

// The path through the point with barycentrics `place`, where the objective vanishes.
Path path_at(Query query, VisiblePoint point, Light light, uint triangle, vec2 place) {
    SpecularTriangle corners = specular_triangles[triangle];
    Instance instance = instances[corners.instance];
    SpecularVertex a = specular_vertices[corners.corner.x];
    SpecularVertex b = specular_vertices[corners.corner.y];
    SpecularVertex c = specular_vertices[corners.corner.z];
    vec3 weight = weights(place);
    vec3 first = b.position - a.position;
    vec3 second = c.position - a.position;
    vec3 face = cross(first, second);
    float face2 = max(dot(face, face), 1e-37);
    Path path;
    path.rejected = 0u;
    path.irradiance = vec3(0.0);
    path.at = (a.position - query.point) * weight.x + (b.position - query.point) * weight.y +
              (c.position - query.point) * weight.z;
    vec3 reach = max(max(abs(a.position), abs(b.position)), abs(c.position));
    path.reach = max(max(reach.x, reach.y), reach.z);
    path.geometric = face * inversesqrt(face2);
    if (instance.mirrored != 0u) path.geometric = -path.geometric;
    vec3 way = way_to_light(query, path.at);
    path.light_distance = query.directional ? FAR_AWAY : length(way);
    path.to_light = normalize(way);
    path.point_distance = length(path.at);
    vec3 to_point = -path.at / path.point_distance;

    // Which side is which is the face's to say, and the shading normal has to agree.
    Material material = materials[instance.material];
    bool light_in_front = dot(path.to_light, path.geometric) > 0.0;
    bool point_in_front = dot(to_point, path.geometric) > 0.0;
    bool fits = (light_in_front ? material.front : material.back) == light.medium &&
                (point_in_front ? material.front : material.back) == point.medium;
    vec3 raw = a.normal * weight.x + b.normal * weight.y + c.normal * weight.z;
    float size = max(length(raw), 1e-37);
    vec3 normal = raw / size;
    if (dot(normal, path.to_light) < 0.0) {
        normal = -normal;
        size = -size;
    }
    float cos_in = dot(normal, path.to_light);
    if (!fits || light_in_front == point_in_front || dot(normal, to_point) >= 0.0 ||
        dot(normal, light_in_front ? path.geometric : -path.geometric) <= 0.0) {
        path.rejected = COUNT_WRONG_SIDE;
        return path;
    }
    float cos_point = dot(-to_point, unpack_direction(point.normal));
    if (cos_point <= 0.0 || dot(-to_point, unpack_direction(point.geometric)) <= 0.0) {
        path.rejected = COUNT_BEHIND;
        return path;
    }

    float eta = query.light_index / query.point_index;
    float cos_out = sqrt(max(1.0 - eta * eta * (1.0 - cos_in * cos_in), 1e-12));
    mat2x3 dual = mat2x3(cross(second, face) / face2, cross(face, first) / face2);
    mat2x3 normal_steps = mat2x3((b.normal - a.normal) / size, (c.normal - a.normal) / size);
    vec3 u, v;
    basis(path.to_light, u, v);
    vec3 along_u = carried(u, query.directional, path.light_distance, path.point_distance, -path.to_light, to_point,
                           path.geometric, normal, eta, cos_in, cos_out, dual, normal_steps);
    vec3 along_v = carried(v, query.directional, path.light_distance, path.point_distance, -path.to_light, to_point,
                           path.geometric, normal, eta, cos_in, cos_out, dual, normal_steps);
    // m2 at P across the path; a steradian at L, or a square metre across the light.
    float area = length(cross(along_u, along_v));
    vec3 power = light.intensity;
    if (light.kind == LIGHT_SPOT) power *= spot_falloff(light, -path.to_light);
    vec3 medium = transmittance(point.medium, path.point_distance) * transmittance(light.medium, path.light_distance);
    path.irradiance = power * medium * ((1.0 - fresnel(cos_in, eta)) * cos_point / area);
    if (!all_finite(path.irradiance)) path.rejected = COUNT_NON_FINITE;
    return path;
}
