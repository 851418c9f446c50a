// Takes what a per-sample technique found into the film: the caustic irradiance at this sample's visible points.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/scene.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };
layout(set = 2, binding = 10, std430) buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 11, std430) buffer FilmIrradiance { vec4 film_irradiance[]; };
layout(set = 2, binding = 12, std430) readonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    vec3 irradiance = vec3(0.0);
    vec3 radiance = vec3(0.0);
    if (visible_points[slot].instance != NO_INSTANCE) {
        VisibleShade shade = visible_shades[slot];
        irradiance = sample_irradiance[slot].rgb;
        radiance = irradiance * shade.throughput * shade.albedo / PI;
        if (!all_finite(irradiance) || !all_finite(radiance)) {
            atomicAdd(counters.non_finite, 1u);
            irradiance = vec3(0.0);
            radiance = vec3(0.0);
        }
    }
    // Running means; a sample that saw no point counts as dark.
    float samples = float(frame.index + 1u);
    film_caustic[slot] += (vec4(radiance, 0.0) - film_caustic[slot]) / samples;
    if (slot < pixels) {
        // w: what the odd samples contribute to the channels' mean, for the error estimate.
        float odd = (frame.index & 1u) != 0u ? mean(irradiance) : 0.0;
        film_irradiance[slot] += (vec4(irradiance, odd) - film_irradiance[slot]) / samples;
    }
}
