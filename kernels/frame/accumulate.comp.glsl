// Takes what a per-sample technique found into the film: the caustic irradiance at this sample's visible points.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/scene.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"
#include "shared/caustic.glsl"

layout(set = 2, binding = 10, std430) buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 11, std430) buffer FilmIrradiance { vec4 film_irradiance[]; };
layout(set = 2, binding = 19, std430) buffer FilmCausticVolume { vec4 film_caustic_volume[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    CausticSample found = caustic_sample(slot);
    // Running means; a sample that saw no point counts as dark.
    float samples = float(frame.index + 1u);
    film_caustic[slot] += (vec4(found.radiance, 0.0) - film_caustic[slot]) / samples;
    if (view.segments > 0u) {
        film_caustic_volume[slot] += (vec4(caustic_volume(slot), 0.0) - film_caustic_volume[slot]) / samples;
    }
    if (slot < pixels) {
        // w: what the odd samples contribute to the channels' mean, for the error estimate.
        float odd = (frame.index & 1u) != 0u ? mean(found.irradiance) : 0.0;
        film_irradiance[slot] += (vec4(found.irradiance, odd) - film_irradiance[slot]) / samples;
    }
}
