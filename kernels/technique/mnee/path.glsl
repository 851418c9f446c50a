// The light that a refracted path carries.
#include "shared/media.glsl"
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

// A triangle as light from one side meets it.
struct Face {
    vec3 geometric;      // unit
    mat2x3 dual;         // takes a step in the plane to barycentrics
    mat2x3 normal_steps; // of the normal, not normalised, along the barycentrics
    float eta;           // index on the light's side over the other
};

// What a bundle of rays from the light becomes: how its cross-section moves at the point as the ray turns at the light, or
// moves across a directional light.
struct Bundle {
    vec3 along_u;
    vec3 along_v;
    vec3 refracted; // unit
};

// Derivatives of a ray from the light along one of two directions across it, carried to the plane through P across the
// path: Granizo-Hidalgo and Holzschuch's Eqs. 28-32, from the light's side, with unit vectors along the light's travel.
//
// What belongs to irradiance at P is the area there over the solid angle at L (Eq. 25 has the reverse, which lacks the
// squared ratio of the indices), and n' is the derivative of the normalised normal.
vec3 carried(Face face, vec3 across, bool directional, float light_distance, float point_distance, vec3 incident,
             vec3 refracted, vec3 normal, float size, float cos_in, float cos_out) {
    vec3 turn = directional ? vec3(0.0) : across;
    vec3 moved = directional ? across : light_distance * across;
    moved -= dot(moved, face.geometric) / dot(incident, face.geometric) * incident;
    vec3 turned = (face.normal_steps[0] * dot(moved, face.dual[0]) + face.normal_steps[1] * dot(moved, face.dual[1])) / size;
    turned -= dot(turned, normal) * normal;
    float cos_in_turn = -dot(turn, normal) - dot(incident, turned);
    float slope = face.eta - face.eta * face.eta * cos_in / cos_out;
    vec3 refracted_turn =
        face.eta * turn + slope * cos_in_turn * normal + (face.eta * cos_in - cos_out) * turned;
    vec3 landed = moved + point_distance * refracted_turn;
    return landed - dot(landed, refracted) * refracted;
}

// `raw`: the interpolated normal on the light's side, not normalised; u and v: unit, across the ray from the light.
Bundle bundle_at(Face face, vec3 raw, vec3 to_light, vec3 u, vec3 v, bool directional, float light_distance,
                 float point_distance) {
    float size = max(length(raw), 1e-37);
    vec3 normal = raw / size;
    float cos_in = dot(normal, to_light);
    float cos_out = sqrt(max(1.0 - face.eta * face.eta * (1.0 - cos_in * cos_in), 1e-12));
    Bundle bundle;
    bundle.refracted = normalize((face.eta * cos_in - cos_out) * normal - face.eta * to_light);
    bundle.along_u = carried(face, u, directional, light_distance, point_distance, -to_light, bundle.refracted, normal,
                             size, cos_in, cos_out);
    bundle.along_v = carried(face, v, directional, light_distance, point_distance, -to_light, bundle.refracted, normal,
                             size, cos_in, cos_out);
    return bundle;
}

// Area at P across the path over solid angle at L, with the sign of its turn.
float signed_area(Bundle bundle) {
    return dot(cross(bundle.along_u, bundle.along_v), bundle.refracted);
}

// Where light folds, irradiance is infinite along a line, as the inverse root of the distance to it. The mean over the
// distance `width` from the line is twice the value there: points nearer get that, which keeps the energy and moves it by
// no more than `width`. Returns the area to divide by. `moved_area` is the area at a path whose direction at the light is
// turned by `turn` along the direction in which the bundle is narrowest.
float area_near_fold(Bundle bundle, float area, float moved_area, float turn, float width) {
    float uu = dot(bundle.along_u, bundle.along_u);
    float vv = dot(bundle.along_v, bundle.along_v);
    float uv = dot(bundle.along_u, bundle.along_v);
    float wide = sqrt(max(0.5 * (uu + vv) + sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv), 1e-37));
    float slope = abs(moved_area - area) / turn;
    float at_width2 = 2.0 * wide * slope * width; // of the area, at `width` from the fold
    return area * area < at_width2 ? 0.5 * sqrt(at_width2) : abs(area);
}

// The direction across the light's ray, in u and v, along which the bundle is narrowest; unit.
vec2 narrowest(Bundle bundle) {
    float uu = dot(bundle.along_u, bundle.along_u);
    float vv = dot(bundle.along_v, bundle.along_v);
    float uv = dot(bundle.along_u, bundle.along_v);
    float low = 0.5 * (uu + vv) - sqrt(0.25 * (uu - vv) * (uu - vv) + uv * uv);
    vec2 way = abs(uu - low) > abs(vv - low) ? vec2(-uv, uu - low) : vec2(vv - low, -uv);
    float size = length(way);
    return size > 1e-37 ? way / size : vec2(1.0, 0.0);
}

// Of the triangle's size, how far the neighbouring path is taken that tells how the area changes.
const float NEIGHBOUR = 0.02;

// The path through the point with barycentrics `place`, where the objective vanishes. Within `width` (m at the visible
// point) of a fold its irradiance is a mean.
Path path_at(Query query, VisiblePoint point, Light light, uint triangle, vec2 place, float width) {
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
    float side = dot(raw, path.to_light) < 0.0 ? -1.0 : 1.0;
    vec3 normal = side * raw / max(length(raw), 1e-37);
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

    Face from_light;
    from_light.geometric = path.geometric;
    from_light.dual = mat2x3(cross(second, face) / face2, cross(face, first) / face2);
    from_light.normal_steps = mat2x3(side * (b.normal - a.normal), side * (c.normal - a.normal));
    from_light.eta = query.light_index / query.point_index;
    vec3 u, v;
    basis(path.to_light, u, v);
    Bundle bundle = bundle_at(from_light, side * raw, path.to_light, u, v, query.directional, path.light_distance,
                              path.point_distance);
    float area = signed_area(bundle);
    if (width > 0.0) {
        vec2 way = narrowest(bundle);
        vec3 across = way.x * u + way.y * v;
        vec3 step = (query.directional ? 1.0 : path.light_distance) *
                    (across + dot(across, path.geometric) / dot(path.to_light, path.geometric) * -path.to_light);
        float turn = NEIGHBOUR * length(first) / max(length(step), 1e-37);
        step *= turn;
        vec3 neighbour = way_to_light(query, path.at + step);
        vec3 raw_there = side * raw + from_light.normal_steps[0] * dot(step, from_light.dual[0]) +
                         from_light.normal_steps[1] * dot(step, from_light.dual[1]);
        Bundle there = bundle_at(from_light, raw_there, normalize(neighbour), u, v, query.directional,
                                 path.light_distance, path.point_distance);
        area = area_near_fold(bundle, area, signed_area(there), turn, width);
    }
    vec3 power = light_power_along(light, -path.to_light);
    vec3 medium = transmittance(point.medium, query.point, -to_point, path.point_distance) *
                  transmittance(light.medium, query.point + path.at, path.to_light, path.light_distance);
    path.irradiance = power * medium * ((1.0 - fresnel(cos_in, from_light.eta)) * cos_point / abs(area));
    if (!all_finite(path.irradiance)) path.rejected = COUNT_NON_FINITE;
    return path;
}
