// The light of a set at the visible points: as the camera's view has it where it shows the point, else from the cubes.
#include "shared/visible.glsl"
#include "technique/photons/store.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 3, binding = 4, std430) readonly buffer PhotonIrradiance { vec4 photon_irradiance[]; };
layout(push_constant) uniform ShowPush {
    StorePush store;
} push;

// Part of the unit square, about its middle, where `height` + dot(slope, place) is below `bound`; slopes are not negative.
float part_below(float height, vec2 slope, float bound) {
    float steep = max(max(slope.x, slope.y), 1e-6);
    float flat_slope = min(slope.x, slope.y);
    // Along the steep way the part is clamp(v + 1/2, 0, 1), and v falls evenly along the other.
    float middle = (bound - height) / steep + 0.5;
    float fall = flat_slope / steep;
    if (fall < 1e-4) return clamp(middle, 0.0, 1.0);
    return (clamped_integral(middle + 0.5 * fall) - clamped_integral(middle - 0.5 * fall)) / fall;
}

// Area of the plane through `inside` within the unit cube.
float area_in_cube(vec3 inside, vec3 normal) {
    vec3 n = abs(normal);
    uint k = n.x >= n.y && n.x >= n.z ? 0u : n.y >= n.z ? 1u : 2u;
    uint a = (k + 1u) % 3u;
    uint b = (k + 2u) % 3u;
    vec2 slope = -vec2(normal[a], normal[b]) / normal[k];
    float middle = inside[k] + slope.x * (0.5 - inside[a]) + slope.y * (0.5 - inside[b]);
    float part = part_below(middle, abs(slope), 1.0) - part_below(middle, abs(slope), 0.0);
    return part / n[k];
}

// Of a cube, the least area that light is divided by: corners that the plane barely cuts hold too little to tell.
const float LEAST_AREA = 0.05;

vec3 light_in_cube(VisiblePoint point) {
    vec3 normal = unpack_direction(point.geometric);
    int level = cube_level(push.store, length(point.position - view.position));
    vec3 inside;
    ivec3 cube = cube_of(push.store, point.position, level, inside);
    uvec2 key = cube_key(cube, level, side_of(normal));
    for (uint i = 0u; i < push.store.probes; i++) {
        uint slot = 4u * ((key.y + i) & (push.store.cubes - 1u));
        uint found = photon_cubes[slot];
        if (found == EMPTY) return vec3(0.0);
        if (found != key.x) continue;
        vec3 units = vec3(photon_cubes[slot + 1u], photon_cubes[slot + 2u], photon_cubes[slot + 3u]);
        float side = cube_side(level);
        return units * (push.store.flux_unit / (max(area_in_cube(inside, normal), LEAST_AREA) * side * side));
    }
    return vec3(0.0);
}

void main() {
    uint slot = linear_index();
    if (slot >= VISIBLE_LAYERS * view.width * view.rows) return;
    VisiblePoint point = visible_points[slot];
    if (point.instance == NO_INSTANCE) return;
    LightView camera = light_views[push.store.camera];
    vec4 at;
    Spot spot = Spot(point.position, point.instance, unpack_direction(point.geometric));
    uint texel = texel_for(push.store, camera, spot, true, at);
    vec3 irradiance = vec3(0.0);
    if (texel != NO_TEXEL) {
        irradiance = photon_irradiance[texel].rgb;
    } else if (push.store.cubes > 0u) {
        irradiance = light_in_cube(point);
    }
    sample_irradiance[slot] = vec4(irradiance, 0.0);
}
