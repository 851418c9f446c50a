// What a beam scatters towards the camera along a stretch of a view ray; one body for all tiers.
#include "shared/media.glsl"
#include "shared/segments.glsl"
#include "technique/beams/volume_push.glsl"
#include "technique/beams/shade.glsl"
#include "technique/beams/interval.glsl"
#include "technique/beams/inverse_area.glsl"
#ifndef EVEN_MEDIA
#include "technique/beams/light_depth.glsl"
#endif

const uint INTEGRAL_CLOSED = 0u;   // the area's part in closed form, the rest by two points a step
const uint INTEGRAL_ADAPTIVE = 1u; // all of it by two points a step, in more steps
const uint INTEGRAL_MIDPOINT = 2u; // one point, as the paper has it

const float MOST_STEPS = 64.0;  // between a beam's ends
const float ALL_DONE = 3e38;    // a place on the ray beyond all
const float DARK_DEPTH = 40.0;  // optical depth beyond which nothing is seen

Section section_along(Beam beam, Crossing c, float t) {
    Section section;
    vec3 parts = numerators(c, t);
    float whole = parts.x + parts.y + parts.z;
    section.y = c.height.x + t * c.height.y;
    section.weights = abs(whole) > 0.0 ? parts / whole : vec3(1.0 / 3.0);
    section.area = 0.5 * twice_area(c, t);
    section.way = section.weights.x * beam.corners[0].way + section.weights.y * beam.corners[1].way +
                  section.weights.z * beam.corners[2].way;
    return section;
}

// Software drivers run code that no invocation needs: EVEN_MEDIA leaves it out.
#ifndef EVEN_MEDIA
// Who includes this says how much is between the stretch's origin and a point of it: m of density 1.
float seen_through(Stretch s, float distance);
#endif

// m of density 1 from where the light left its surface to the section's point, and on to the stretch's origin.
float depth_through(uint index, Beam beam, Stretch s, Section section, float distance) {
#ifndef EVEN_MEDIA
    if (media[beam.medium].grid != NO_GRID) return seen_through(s, distance) + light_depth(index, beam, section);
#endif
    return distance + max(way_since_start(beam, section), 0.0);
}

// Radiance at the stretch's origin per metre and W, times the cross-section's area. The fluence of the light is its flux
// over the area and the cosine to the beam's normal, 1 / |way| (erratum 9). `index` is the beam's.
vec3 scattered_at(ShadePush push, uint index, Beam beam, Stretch s, Crossing c, float t) {
    Section section = section_along(beam, c, t);
    float distance = c.centre + t;
    float size = length(section.way);
    vec3 light = section.way / size;
    float depth = depth_through(index, beam, s, section, distance);
#ifndef EVEN_MEDIA
    vec3 scattering = scattering_at(beam.medium, s.origin + distance * s.direction);
#else
    vec3 scattering = media[beam.medium].scattering;
#endif
    float fade = push.soft > 0.0 ? clamp((s.extent - distance) / push.soft, 0.0, 1.0) : 1.0;
    float strength = phase(beam.medium, -dot(light, s.direction)) * size * beam_weight(push, beam, section) * fade;
    return strength * scattering * exp(-extinction(beam.medium) * depth);
}

// How far from `from` on, in a piece that ends at `end`, the integrand over the area is nearly a line: areas change little
// enough, light turns by less than a quarter of a radian within the piece, and there is half an optical depth at most, or
// a voxel.
float step_from(VolumePush how, Beam beam, Crossing c, float from, float end, float least) {
    if (how.integral == INTEGRAL_MIDPOINT) return end;
    bool fine = how.integral == INTEGRAL_ADAPTIVE;
    vec3 first = beam.corners[0].way;
    vec3 turns = vec3(distance(first, beam.corners[1].way), distance(first, beam.corners[2].way),
                      distance(beam.corners[1].way, beam.corners[2].way));
    float spread = max(turns.x, max(turns.y, turns.z)) / length(first);
    float longest = (end - from) / (1.0 + min(floor((fine ? 16.0 : 4.0) * spread), 8.0));
    vec3 lost = extinction(beam.medium);
    longest = min(longest, (fine ? 0.1 : 0.5) / max(max(lost.x, max(lost.y, lost.z)), 1e-20));
#ifndef EVEN_MEDIA
    uint grid = media[beam.medium].grid;
    if (grid != NO_GRID) {
        vec3 cells = density_grids[grid].cells_per_metre;
        longest = min(longest, 1.0 / max(cells.x, max(cells.y, cells.z)));
    }
#endif
    Area area = area_round(c, from);
    // Areas on the way differ from the first by this part of it at most.
    float change = (fine ? 0.1 : 1.5) * area.constant;
    float slope = abs(area.linear);
    float even = 2.0 * change / max(slope + sqrt(slope * slope + 4.0 * change * abs(area.square)), 1e-30);
    float next = from + max(min(longest, even), least);
    return next > mix(from, end, 0.99) ? end : next;
}

// One step's part of the integral over the piece of the ray that is inside the beam, W of flux apart.
vec3 step_integral(ShadePush push, VolumePush how, uint index, Beam beam, Stretch s, Crossing c, vec2 step) {
    float middle = 0.5 * (step.x + step.y);
    float extent = 0.5 * (step.y - step.x);
    Area area = area_round(c, middle);
    float before = max(way_since_start(beam, section_along(beam, c, middle)), 0.0);
    float floor_area = least_area(push, before);
    // Gauss's two points are good for cubics. How many there are is the device's to read, so that a point is compiled once.
    bool single = how.integral == INTEGRAL_MIDPOINT;
    float place = single ? 0.0 : extent * INVERSE_ROOT_3;
    vec2 weights = vec2(extent) / max(vec2(area_over(area, -place), area_over(area, place)), floor_area);
    if (how.integral == INTEGRAL_CLOSED) {
        vec2 moments = inverse_moments(area, extent, floor_area);
        weights = 0.5 * (moments.x + vec2(-1.0, 1.0) * moments.y / place);
    }
    vec3 sum = vec3(0.0);
    for (uint i = 0u; i < (single ? 1u : 2u); i++) {
        float weight = single ? 2.0 * weights.x : weights[i];
        sum += weight * scattered_at(push, index, beam, s, c, middle + (i == 0u ? -place : place));
    }
    return sum;
}

// The part of a stretch that can be bright.
vec2 seen_part(Stretch s) {
#ifndef EVEN_MEDIA
    if (media[s.medium].grid != NO_GRID) return dense_part(s.medium, s.origin, s.direction, s.extent);
#endif
    vec3 lost = extinction(s.medium);
    return vec2(0.0, min(s.extent, DARK_DEPTH / max(min(lost.x, min(lost.y, lost.z)), 1e-20)));
}
