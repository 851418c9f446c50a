// Adds the picture of the paths that are not looked for to the film, or takes it out again.
#include "shared/index.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"

layout(set = 2, binding = 10, std430) buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 11, std430) buffer FilmIrradiance { vec4 film_irradiance[]; };
layout(set = 2, binding = 19, std430) buffer FilmCausticVolume { vec4 film_caustic_volume[]; };
layout(set = 3, binding = 0, std430) readonly buffer RestCaustic { vec4 rest_caustic[]; };
layout(set = 3, binding = 1, std430) readonly buffer RestIrradiance { vec4 rest_irradiance[]; };
layout(set = 3, binding = 2, std430) readonly buffer RestCausticVolume { vec4 rest_caustic_volume[]; };
layout(push_constant) uniform RestPush { float sign; } push;

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    film_caustic[slot] += push.sign * rest_caustic[slot];
    if (view.segments > 0u) film_caustic_volume[slot] += push.sign * rest_caustic_volume[slot];
    if (slot < pixels) film_irradiance[slot] += push.sign * rest_irradiance[slot];
}
