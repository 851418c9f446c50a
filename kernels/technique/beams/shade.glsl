// How much light a beam brings to a point inside it; one body for all tiers.
#include "shared/media.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/shade_push.glsl"

// The light's size on a plane a way off: no cross-section is smaller, and so no light is infinite (erratum 8).
float least_area(ShadePush push, float distance) {
    float size = push.light_angle * distance;
    return max(size * size, 1e-20);
}

// Of the shading normal's cosine to the face's: a bound for light that grazes a face.
const float MAX_COSINE_RATIO = 8.0;

// A corner's irradiance, by the area function of all light round it, stands for the beam's where it is of its size: at a
// fold, areas of both signs cancel there, and what is left says nothing.
const float MOST_CONTRAST = 3.0;

// Light at a point over the mean of the beam's cross-section, interpolated between its corners' (Ernst et al. 2005).
// Barycentrics average to a third, so that the beam keeps its flux.
float beam_weight(ShadePush push, Beam beam, Section section) {
    if (push.smooth_area == 0u) return 1.0;
    float own = max(mean(beam.flux), 1e-37) / section.area;
    vec3 ratios = vec3(1.0);
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner corner = beam.corners[i];
        float l = max(section.y - corner.start, 0.0) * length(corner.way);
        float area = corner.area.x + l * (corner.area.y + l * corner.area.z);
        float ratio = corner.flux / area / own;
        // False for NaN, too.
        if (ratio > 1.0 / MOST_CONTRAST && ratio < MOST_CONTRAST) ratios[i] = ratio;
    }
    return 3.0 * dot(section.weights, ratios) / (ratios.x + ratios.y + ratios.z);
}

// m along the light's way since it left its surface.
float way_since_start(Beam beam, Section section) {
    return (section.y - dot(section.weights, beam_starts(beam))) * length(section.way);
}

// Irradiance at a point that the beam holds, per W of the beam on average over its cross-section; 0 where it arrives from
// behind. Across the beam's planes the light's cosine is 1 / |way| (erratum 9).
float density_at_point(ShadePush push, Beam beam, Section section, vec3 shading, vec3 geometric) {
    float cosine = -dot(section.way, shading);
    if (cosine <= 0.0 || dot(section.way, geometric) >= 0.0) return 0.0;
    return cosine / max(abs(section.area), least_area(push, way_since_start(beam, section)));
}

// The same for an area of which a part of the beam's light falls on every m2. Flux over area goes by the face; irradiance,
// like direct light's, goes by the shading normal.
float density_on_area(Section section, float part_per_area, vec3 shading, vec3 geometric) {
    float cosine = -dot(section.way, shading);
    float face = -dot(section.way, geometric);
    return cosine <= 0.0 || face <= 0.0 ? 0.0 : part_per_area * min(cosine / face, MAX_COSINE_RATIO);
}

// The beam's light of that density at a point, W/m2, if nothing is in its way; `start` is where it leaves the specular
// surface.
vec3 arriving_light(ShadePush push, Beam beam, Section section, vec3 point, float density, out vec3 start) {
    vec3 direction = normalize(section.way);
    float before = way_since_start(beam, section);
    start = point - before * direction;
    if (before <= 0.0 || density <= 0.0) return vec3(0.0);
    return beam.flux * (density * beam_weight(push, beam, section)) *
           transmittance(beam.medium, start, direction, before);
}
