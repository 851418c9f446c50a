// Light that comes straight to the visible points: L D. Specular surfaces block it; what comes through them is caustic
// light and the technique's.
#include "shared/index.glsl"
#include "shared/media.glsl"
#include "shared/optics.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    VisiblePoint point = visible_points[slot];
    if (point.instance == NO_INSTANCE) return;
    VisibleShade shade = visible_shades[slot];
    vec3 normal = unpack_direction(point.normal);
    vec3 geometric = unpack_direction(point.geometric);

    vec3 irradiance = vec3(0.0);
    for (uint index = 0u; index < view.lights; index++) {
        LightSample light = light_at(lights[index], point.position);
        float cosine = dot(light.to_light, normal);
        if (lights[index].medium != point.medium || cosine <= 0.0 || dot(light.to_light, geometric) <= 0.0) continue;
        if (mean(light.irradiance) <= 0.0) continue;
        if (!trace_occluded(Ray(point.position, 0.0, light.to_light, light.distance), MASK_ALL)) {
            irradiance += light.irradiance * cosine *
                          transmittance(point.medium, point.position, light.to_light, light.distance);
        }
    }
    vec3 radiance = shade.throughput * shade.albedo / PI * irradiance;
    if (all_finite(radiance)) {
        film_direct[slot] += vec4(radiance, 0.0);
    } else {
        atomicAdd(counters.non_finite, 1u);
    }
    if (slot < pixels) {
        film_albedo[slot] += vec4(shade.albedo, 1.0);
        film_normal[slot] += vec4(normal, shade.distance);
    }
}
