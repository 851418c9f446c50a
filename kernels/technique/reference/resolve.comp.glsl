// What the statistics say after `passes` passes: flux over area and passes.
#include "technique/reference/common.glsl"

layout(set = 3, binding = 1, std430) readonly buffer Statistics { Statistic statistics[]; };
layout(set = 3, binding = 9, std430) readonly buffer HalfFluxes { float half_fluxes[]; };
layout(set = 2, binding = 10, std430) writeonly buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 11, std430) writeonly buffer FilmIrradiance { vec4 film_irradiance[]; };
layout(push_constant) uniform ResolvePush { uint passes; } push;

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    Statistic statistic = statistics[slot];
    float scale = statistic.radius2 > 0.0 ? 1.0 / (PI * statistic.radius2 * float(push.passes)) : 0.0;
    film_caustic[slot] = vec4(statistic.radiance_flux * scale, 0.0);
    if (slot < pixels) {
        // w: what one half of the passes contributes to the channels' mean, for the error estimate.
        film_irradiance[slot] = vec4(statistic.irradiance_flux, half_fluxes[slot]) * scale;
    }
}
