// Light that comes straight from lamps to the stretches of camera paths in media that scatter, and is scattered into them
// once: L V. Surfaces block it; what comes through specular ones is caustic light and the technique's.
#include "shared/index.glsl"
#include "shared/airlight.glsl"
#include "shared/random.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"
#include "shared/round.glsl"
#include "shared/segments.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 18, std430) buffer FilmVolume { vec4 film_volume[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    uint slots = pixels * VISIBLE_LAYERS;
    if (slot >= slots) return;
    RoundSample at = RoundSample(slot % pixels, frame.index, vec2(0.0));
    if (frame.listed != 0u) at = round_samples[slot % pixels];
    // 3 and 4: the layers' walks have the seeds 0 and 1, the jitter 2.
    uint seed = combine(combine(view.seed, at.pixel + view.first_row * view.width), 3u + slot / pixels);

    vec3 radiance = vec3(0.0);
    for (uint k = 0u; k < view.segments; k++) {
        Stretch s = stretch(k, slot, slots);
        if (s.medium == NO_MEDIUM) break;
        for (uint index = 0u; index < view.lights; index++) {
            Light light = lights[index];
            Airlight air;
            if (light.medium != s.medium) continue;
            if (!airlight(light, s.origin, s.direction, s.extent, s.medium, s.throughput, air)) continue;
            vec3 sum = vec3(0.0);
            // Evenly spread with one random offset: unbiased, and with 16 places a quarter of the error of as many that
            // are stratified.
            float offset = sample_1d(at.index, combine(seed, index * SEGMENTS + k));
            for (uint i = 0u; i < view.volume_samples; i++) {
                float random = (float(i) + offset) / float(view.volume_samples);
                Place place = airlight_place(air, light, random);
                place.radiance *= transmittance(s.medium, place.position, place.to_light, place.distance);
                if (all_finite(place.radiance) && mean(place.radiance) <= 0.0) continue;
                if (!trace_occluded(Ray(place.position, 0.0, place.to_light, place.distance), MASK_ALL)) {
                    sum += place.radiance;
                }
            }
            radiance += sum / float(view.volume_samples);
        }
    }
    if (all_finite(radiance)) {
        film_volume[slot] += vec4(radiance, 0.0);
    } else {
        atomicAdd(counters.non_finite, 1u);
    }
}
