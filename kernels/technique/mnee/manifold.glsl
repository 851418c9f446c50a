// Newton's method on the surface (Hanika et al. 2015, Zeltner et al. 2020): what the walk along the curve is held against.
#include "technique/mnee/objective.glsl"

// Where Newton's method is on the surface.
struct Guess {
    vec3 at;       // M - P
    uint triangle;
    vec2 place;
    vec3 step;     // in the triangle's plane, to where the linear model has its root
    vec2 place_step; // the same in barycentrics
    float residual; // what of the half vector is not along the normal
};

// The half vector's derivative as M moves.
vec3 half_vector_moved(Query query, vec3 moved, vec3 to_light, float light_distance, vec3 from_point, float point_distance) {
    vec3 turn = query.point_index / point_distance * (moved - dot(moved, from_point) * from_point);
    if (!query.directional) turn += query.light_index / light_distance * (moved - dot(moved, to_light) * to_light);
    return -turn;
}

// The constraint's two components are the half vector's along two tangents that turn with the interpolated normal n; of
// their derivatives, those of the tangents come to -(h . n) n'.
Guess guess_at(Query query, uint triangle, vec2 place) {
    SpecularTriangle corners = specular_triangles[triangle];
    SpecularVertex a = specular_vertices[corners.corner.x];
    SpecularVertex b = specular_vertices[corners.corner.y];
    SpecularVertex c = specular_vertices[corners.corner.z];
    vec3 weight = weights(place);
    Guess guess;
    guess.triangle = triangle;
    guess.place = place;
    guess.at = (a.position - query.point) * weight.x + (b.position - query.point) * weight.y +
               (c.position - query.point) * weight.z;
    vec3 raw = a.normal * weight.x + b.normal * weight.y + c.normal * weight.z;
    float size = max(length(raw), 1e-37);
    vec3 normal = raw / size;
    vec3 way = way_to_light(query, guess.at);
    float light_distance = max(length(way), 1e-37);
    vec3 to_light = way / light_distance;
    float point_distance = max(length(guess.at), 1e-37);
    vec3 from_point = guess.at / point_distance;
    vec3 half_way = half_vector(query, guess.at);
    float along = dot(half_way, normal) / size;

    vec3 first = b.position - a.position;
    vec3 second = c.position - a.position;
    vec3 by_first = half_vector_moved(query, first, to_light, light_distance, from_point, point_distance) -
                    along * (b.normal - a.normal);
    vec3 by_second = half_vector_moved(query, second, to_light, light_distance, from_point, point_distance) -
                     along * (c.normal - a.normal);
    vec3 u, v;
    basis(normal, u, v);
    vec2 value = vec2(dot(u, half_way), dot(v, half_way));
    vec2 column_first = vec2(dot(u, by_first), dot(v, by_first));
    vec2 column_second = vec2(dot(u, by_second), dot(v, by_second));
    float determinant = column_first.x * column_second.y - column_first.y * column_second.x;
    vec2 moved = vec2(value.x * column_second.y - value.y * column_second.x,
                      value.y * column_first.x - value.x * column_first.y) /
                 (abs(determinant) > 1e-37 ? determinant : 1e-37);
    guess.place_step = -moved;
    guess.step = -(first * moved.x + second * moved.y);
    guess.residual = length(value);
    return guess;
}
