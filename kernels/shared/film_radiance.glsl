// The picture in the film: all light of both layers.

layout(set = 2, binding = 6, std430) readonly buffer FilmDirect { vec4 film_direct[]; };
layout(set = 2, binding = 10, std430) readonly buffer FilmCaustic { vec4 film_caustic[]; };
layout(set = 2, binding = 18, std430) readonly buffer FilmVolume { vec4 film_volume[]; };
layout(set = 2, binding = 19, std430) readonly buffer FilmCausticVolume { vec4 film_caustic_volume[]; };

// Of one of so many pixels. `samples`: those that direct light and single scattering are sums of; caustic light is the
// estimate already. `volume`: the film has light that media scatter.
vec3 film_radiance(uint pixel, uint pixels, float samples, bool volume) {
    vec3 radiance = vec3(0.0);
    for (uint layer = 0u; layer < 2u; layer++) {
        uint slot = layer * pixels + pixel;
        radiance += film_direct[slot].rgb / samples + film_caustic[slot].rgb;
        if (volume) radiance += film_volume[slot].rgb / samples + film_caustic_volume[slot].rgb;
    }
    return radiance;
}
