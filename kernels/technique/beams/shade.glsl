// How much light a beam brings to a point inside it; one body for all tiers.
#include "shared/media.glsl"
#include "technique/beams/section.glsl"

struct ShadePush {
    float light_angle; // radians that the light subtends where it is seen through the specular surfaces, at least
    uint smooth_area;  // 1: the area function is interpolated between corners, 0: it is the beam's own
    uint shadows;      // SHADOW_POINTS or SHADOW_EDGES
    float soft;        // m before a surface within which volume light fades, 0 for none
};

// The light's size on a plane a way off: no cross-section is smaller, and so no light is infinite (erratum 8).
float least_area(ShadePush push, float distance) {
    float size = push.light_angle * distance;
    return max(size * size, 1e-20);
}

// Light at a point over the mean of its cross-section. The corners' irradiances, each by the area function of what is round
// that corner, are shared with the neighbours; barycentrics average to a third, so the beam's flux stays its own.
float beam_weight(ShadePush push, Beam beam, Section section) {
    if (push.smooth_area == 0u) return 1.0;
    vec3 irradiance = vec3(0.0);
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner corner = beam.corners[i];
        float l = max(section.y - corner.start, 0.0) * length(corner.way);
        float area = abs(corner.area.x + l * (corner.area.y + l * corner.area.z));
        irradiance[i] = corner.flux / max(area, least_area(push, l));
    }
    float even = (irradiance.x + irradiance.y + irradiance.z) / 3.0;
    return even > 0.0 ? dot(section.weights, irradiance) / even : 1.0;
}

// m along the light's way since it left its surface.
float way_since_start(Beam beam, Section section) {
    return (section.y - dot(section.weights, beam_starts(beam))) * length(section.way);
}

// The beam's light on a surface with these normals, W/m2, if nothing is in its way; `start` is where it leaves the
// specular surface. Across the beam's planes the light's cosine is 1 / |way| (erratum 9).
vec3 beam_irradiance(ShadePush push, Beam beam, Section section, vec3 point, vec3 shading, vec3 geometric, out vec3 start) {
    vec3 direction = normalize(section.way);
    float before = way_since_start(beam, section);
    start = point - before * direction;
    float cosine = -dot(section.way, shading);
    if (before <= 0.0 || cosine <= 0.0 || dot(section.way, geometric) >= 0.0) return vec3(0.0);
    float density = beam_weight(push, beam, section) / max(abs(section.area), least_area(push, before));
    return beam.flux * density * cosine * transmittance(beam.medium, start, direction, before);
}
