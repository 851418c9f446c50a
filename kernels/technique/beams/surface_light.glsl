// A beam's light at a visible point, its shadow included.
#include "shared/visible.glsl"
#include "technique/beams/shade.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/tally_names.glsl"

// Who includes this counts.
void count(uint what);

// Whether a beam has a point in it.
bool holds_point(Beam beam, VisiblePoint point, out Section section) {
    if (beam.medium != point.medium) return false;
    return section_at(beam, point.position, section) && section.y <= beam_range(beam).y;
}

// What is left of the light that arrives at `at` from `start` when shadows are looked for.
vec3 unshadowed(ShadePush push, Beam beam, Section section, vec3 at, vec3 start, vec3 light) {
    if (!all_finite(light) || !all_finite(start)) {
        count(TALLY_NON_FINITE);
        return vec3(0.0);
    }
    if (mean(light) <= 0.0) return vec3(0.0);
    count(TALLY_FRAGMENTS);
    if (!wants_ray(beam, section, push.shadows)) return light;
    count(TALLY_RAYS);
    if (!is_shadowed(beam, at, start)) return light;
    count(TALLY_SHADOWED);
    return vec3(0.0);
}

// W/m2, at a point that the beam holds.
vec3 surface_light(ShadePush push, Beam beam, VisiblePoint point, Section section) {
    vec3 start;
    float density = density_at_point(push, beam, section, unpack_direction(point.normal),
                                     unpack_direction(point.geometric));
    vec3 found = arriving_light(push, beam, section, point.position, density, start);
    return unshadowed(push, beam, section, point.position, start, found);
}
