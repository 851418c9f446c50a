// Takes a round's samples into the film, one invocation a pixel: in the order of the pixel's sequence, so that sums do
// not depend on which invocation comes first.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/scene.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"
#include "shared/caustic.glsl"
#include "shared/round.glsl"

layout(set = 2, binding = 5, std430) readonly buffer PixelPlans { PixelPlan pixel_plans[]; };
layout(set = 2, binding = 10, std430) buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 11, std430) buffer FilmIrradiance { vec4 film_irradiance[]; };
layout(set = 2, binding = 18, std430) buffer FilmVolume { vec4 film_volume[]; };
layout(set = 2, binding = 19, std430) buffer FilmCausticVolume { vec4 film_caustic_volume[]; };
// What frame/walk, frame/direct and frame/volume wrote for each slot of this round; zero again afterwards.
layout(set = 2, binding = 13, std430) buffer RoundDirect { vec4 round_direct[]; };
layout(set = 2, binding = 14, std430) buffer RoundAlbedo { vec4 round_albedo[]; };
layout(set = 2, binding = 15, std430) buffer RoundNormal { vec4 round_normal[]; };
layout(set = 2, binding = 21, std430) buffer RoundVolume { vec4 round_volume[]; };
// x: mean of the pilot's radiance, y: sum of the squared deviations from it.
layout(set = 2, binding = 16, std430) buffer PilotMoments { vec2 pilot_moments[]; };
layout(push_constant) uniform MergePush { RoundPush push; };

void main() {
    uint pixel = linear_index();
    uint pixels = view.width * view.rows;
    if (pixel >= pixels) return;
    Places places = places_of(pixel, pixel_plans[pixel], push, pixels);
    if (places.from == places.to) return;

    vec4 albedo = vec4(0.0);
    vec4 normal = vec4(0.0);
    vec4 irradiance = vec4(0.0); // w: of the odd samples, the channels' mean
    vec3 direct[VISIBLE_LAYERS] = vec3[VISIBLE_LAYERS](vec3(0.0), vec3(0.0));
    vec3 caustic[VISIBLE_LAYERS] = vec3[VISIBLE_LAYERS](vec3(0.0), vec3(0.0));
    vec3 volume[VISIBLE_LAYERS] = vec3[VISIBLE_LAYERS](vec3(0.0), vec3(0.0));
    vec3 focused[VISIBLE_LAYERS] = vec3[VISIBLE_LAYERS](vec3(0.0), vec3(0.0)); // caustic light that media scatter
    float radiance = 0.0; // of the last sample, all of it
    for (uint place = places.from; place < places.to; place++) {
        radiance = 0.0;
        for (uint layer = 0u; layer < VISIBLE_LAYERS; layer++) {
            uint slot = layer * pixels + place;
            CausticSample found = caustic_sample(slot);
            vec3 lit = round_direct[slot].rgb;
            round_direct[slot] = vec4(0.0);
            direct[layer] += lit;
            caustic[layer] += found.radiance;
            radiance += mean(lit + found.radiance);
            if (view.segments > 0u) {
                vec3 scattered = round_volume[slot].rgb;
                vec3 caustic_scattered = caustic_volume(slot);
                round_volume[slot] = vec4(0.0);
                volume[layer] += scattered;
                focused[layer] += caustic_scattered;
                radiance += mean(scattered + caustic_scattered);
            }
            if (layer > 0u) continue;
            bool odd = ((places.taken + place - places.from) & 1u) != 0u;
            irradiance += vec4(found.irradiance, odd ? mean(found.irradiance) : 0.0);
        }
        albedo += round_albedo[place];
        normal += round_normal[place];
        round_albedo[place] = vec4(0.0);
        round_normal[place] = vec4(0.0);
    }

    float before = float(places.taken);
    float samples = before + float(places.to - places.from);
    for (uint layer = 0u; layer < VISIBLE_LAYERS; layer++) {
        uint slot = layer * pixels + pixel;
        film_direct[slot] += vec4(direct[layer], 0.0);
        film_caustic[slot] = (film_caustic[slot] * before + vec4(caustic[layer], 0.0)) / samples;
        if (view.segments == 0u) continue;
        film_volume[slot] += vec4(volume[layer], 0.0);
        film_caustic_volume[slot] = (film_caustic_volume[slot] * before + vec4(focused[layer], 0.0)) / samples;
    }
    film_irradiance[pixel] = (film_irradiance[pixel] * before + irradiance) / samples;
    film_albedo[pixel] += albedo;
    film_normal[pixel] += normal;

    if (push.index < push.pilot) { // one sample a round
        vec2 moments = pilot_moments[pixel];
        float difference = radiance - moments.x;
        moments.x += difference / samples;
        moments.y += difference * (radiance - moments.x);
        pilot_moments[pixel] = moments;
    }
}
