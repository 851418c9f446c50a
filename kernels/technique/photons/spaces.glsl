// Image spaces: what lights and the camera see of what is opaque, as ids and as a pyramid of depths. Texel (i, j) covers
// [i, i + 1) x [j, j + 1); its middle is the lattice point of shared/light_view.glsl. Depths are along `forward`, m.
#include "shared/index.glsl"
#include "shared/light_view.glsl"

layout(set = 3, binding = 0, std430) readonly buffer LightViews { LightView light_views[]; }; // the camera's is the last
layout(set = 3, binding = 1, std430) buffer OpaqueIds { uvec2 opaque_ids[]; };                // instance + 1, primitive
layout(set = 3, binding = 2, std430) buffer DepthSlabs { vec2 depth_slabs[]; };               // nearest and farthest
layout(set = 3, binding = 3, std430) readonly buffer DepthLevels { uint depth_levels[]; };    // first slab, by view and level

// Levels that a pyramid can have.
const uint DEPTH_LEVELS = 16u;
// Of the slabs of texels that see nothing: no ray is behind what is infinitely far away.
const float NOTHING = 1e30;
// m before a view's origin: nothing nearer is in it.
const float NEAREST = 1e-4;

uvec2 size_at(LightView v, uint level) {
    return (uvec2(v.columns, v.rows) + (1u << level) - 1u) >> level;
}

uint slab_index(LightView v, uint view_index, uint level, uvec2 node) {
    return depth_levels[view_index * DEPTH_LEVELS + level] + node.y * size_at(v, level).x + node.x;
}

uint id_index(LightView v, uvec2 texel) {
    return v.first_texel + texel.y * v.columns + texel.x;
}

// Where a point is in the view: texels times w, w, and depth. w is the depth in a frustum and 1 in a box.
vec4 place_of(LightView v, vec3 from_origin) {
    float depth = dot(from_origin, v.forward);
    float w = v.perspective != 0u ? depth : 1.0;
    vec2 across = vec2(dot(from_origin, v.right), dot(from_origin, v.up));
    vec2 scale = vec2(v.columns - 1u, v.rows - 1u) / (v.upper - v.lower);
    return vec4((across - v.lower * w) * scale + 0.5 * w, w, depth);
}

// The same of a direction, so that a ray's place is that of its origin plus t times this.
vec4 place_along(LightView v, vec3 direction) {
    float depth = dot(direction, v.forward);
    float w = v.perspective != 0u ? depth : 0.0;
    vec2 across = vec2(dot(direction, v.right), dot(direction, v.up));
    vec2 scale = vec2(v.columns - 1u, v.rows - 1u) / (v.upper - v.lower);
    return vec4((across - v.lower * w) * scale + 0.5 * w, w, depth);
}

// Chart coordinates of a texel's middle.
vec2 chart_of(LightView v, uvec2 texel) {
    return chart_at(v, light_texel_place(v, texel));
}

// m across a texel at this depth.
float texel_width(LightView v, float depth) {
    vec2 step = (v.upper - v.lower) / vec2(v.columns - 1u, v.rows - 1u);
    return max(step.x, step.y) * (v.perspective != 0u ? depth : 1.0);
}

// The plane of a triangle that a view sees, its normal on the side that is seen.
struct SeenPlane {
    vec3 point;
    vec3 normal;
};

SeenPlane plane_of(LightView v, uvec2 ids) {
    vec3 a, b, c;
    triangle_corners(ids.x - 1u, ids.y, a, b, c);
    vec3 normal = normalize(cross(b - a, c - a));
    vec3 way = v.perspective != 0u ? a - v.origin : v.forward;
    return SeenPlane(a, dot(normal, way) > 0.0 ? -normal : normal);
}

// Metres along the ray to where it meets the plane; negative behind it, infinite along it.
float plane_distance(SeenPlane plane, vec3 origin, vec3 direction) {
    return dot(plane.normal, plane.point - origin) / dot(plane.normal, direction);
}

// Depth of the plane at a point of the chart; negative or infinite where it is not before the view.
float plane_depth(LightView v, SeenPlane plane, vec2 at) {
    vec3 across = at.x * v.right + at.y * v.up;
    bool perspective = v.perspective != 0u;
    vec3 from = perspective ? v.origin : v.origin + across;
    return plane_distance(plane, from, perspective ? v.forward + across : v.forward);
}

// Of the point of a triangle nearest to one in its plane, about: weights below zero are taken away.
vec2 barycentrics_of(uvec2 ids, vec3 point) {
    vec3 a, b, c;
    triangle_corners(ids.x - 1u, ids.y, a, b, c);
    vec3 normal = cross(b - a, c - a);
    vec3 weights = max(vec3(dot(normal, cross(b - point, c - point)), dot(normal, cross(c - point, a - point)),
                            dot(normal, cross(a - point, b - point))), vec3(0.0));
    float sum = weights.x + weights.y + weights.z;
    return sum > 0.0 ? weights.yz / sum : vec2(1.0 / 3.0);
}

// The surface that a texel of the opaque layer shows at a point of the chart.
Surface surface_shown(LightView v, uvec2 ids, vec2 at) {
    vec3 origin, direction;
    light_ray(v, at, origin, direction);
    float t = plane_distance(plane_of(v, ids), origin, direction);
    return surface_at(ids.x - 1u, ids.y, barycentrics_of(ids, origin + t * direction));
}
