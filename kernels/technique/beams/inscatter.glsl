// What a beam scatters towards the camera along a stretch of a view ray; one body for all tiers.
#include "shared/media.glsl"
#include "shared/segments.glsl"
#include "technique/beams/volume_push.glsl"
#include "technique/beams/shade.glsl"
#include "technique/beams/interval.glsl"
#include "technique/beams/inverse_area.glsl"

const uint INTEGRAL_CLOSED = 0u;   // the area's part in closed form, the rest by two points a step
const uint INTEGRAL_ADAPTIVE = 1u; // more and more points until the sum stays
const uint INTEGRAL_MIDPOINT = 2u; // one point, as the paper has it

const uint MOST_STEPS = 64u;
const uint MOST_ROUNDS = 7u;      // of the adaptive integral: 64 steps in the last
const float ADAPTED = 1e-3;      // change from round to round at which it is done
const float LARGEST_RATIO = 1.7; // of areas within one step
const float GROWTH = 2.0;        // of steps away from where the area is small
const float DARK_DEPTH = 40.0;   // optical depth beyond which nothing is seen

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

// Who includes this says how much is between the stretch's origin and a point of it: m of density 1.
float seen_through(Stretch s, float distance);

// Radiance at the stretch's origin per metre and W, times the cross-section's area. The fluence of the light is its flux
// over the area and the cosine to the beam's normal, 1 / |way| (erratum 9).
vec3 scattered_at(ShadePush push, Beam beam, Stretch s, Crossing c, float t) {
    Section section = section_along(beam, c, t);
    float distance = c.centre + t;
    float size = length(section.way);
    vec3 light = section.way / size;
    float before = max(way_since_start(beam, section), 0.0);
    vec3 point = s.origin + distance * s.direction;
    float depth = seen_through(s, distance) + density_along(beam.medium, point - before * light, light, before);
    vec3 scattering = scattering_at(beam.medium, point);
    float fade = push.soft > 0.0 ? clamp((s.extent - distance) / push.soft, 0.0, 1.0) : 1.0;
    float strength = phase(beam.medium, -dot(light, s.direction)) * size * beam_weight(push, beam, section) * fade;
    return strength * scattering * exp(-extinction(beam.medium) * depth);
}

// m within which the integrand over the area is nearly a line: less than an optical depth on both legs, or a voxel; and
// over `size` metres light does not turn by more than a quarter of a radian.
float longest_step(Beam beam, float size) {
    vec3 first = beam.corners[0].way;
    vec3 turns = vec3(distance(first, beam.corners[1].way), distance(first, beam.corners[2].way),
                      distance(beam.corners[1].way, beam.corners[2].way));
    float spread = max(turns.x, max(turns.y, turns.z)) / length(first);
    float least = size / (1.0 + min(floor(4.0 * spread), 8.0));
    uint grid = media[beam.medium].grid;
    if (grid != NO_GRID) {
        vec3 cells = density_grids[grid].cells_per_metre;
        return min(least, 1.0 / max(cells.x, max(cells.y, cells.z)));
    }
    vec3 lost = extinction(beam.medium);
    return min(least, 0.5 / max(max(lost.x, max(lost.y, lost.z)), 1e-20));
}

// The integral over a piece of the ray on which the beam's area has one sign, W of flux apart.
vec3 piece_integral(ShadePush push, VolumePush how, Beam beam, Stretch s, Crossing c, vec2 piece) {
    float size = piece.y - piece.x;
    Area whole = area_round(c, 0.5 * (piece.x + piece.y));
    float floor_area = least_area(push, max(way_since_start(beam, section_along(beam, c, 0.5 * (piece.x + piece.y))), 0.0));
    // From the end where the area is small on, with steps that grow as it does; from both sides of its least value where
    // that lies inside.
    float least = least_at(whole, 0.5 * size);
    float longest = max(longest_step(beam, size), size / float(MOST_STEPS / 2u));
    bool closed = how.integral == INTEGRAL_CLOSED;
    uint rounds = how.integral == INTEGRAL_ADAPTIVE ? MOST_ROUNDS : 1u;
    vec3 before = vec3(0.0);
    vec3 sum = vec3(0.0);
    for (uint round = 0u; round < rounds; round++) {
        sum = vec3(0.0);
        for (uint side = 0u; side < 2u; side++) {
            float towards = side == 0u ? 1.0 : -1.0;
            float from = closed ? least : -0.5 * size;
            float reach = side == 0u ? 0.5 * size - from : closed ? from + 0.5 * size : 0.0;
            float ratio = area_over(whole, from + towards * reach) / max(area_over(whole, from), floor_area);
            // Areas grow with the distance or its square, so this many doublings are between the smallest and the largest.
            float doublings = ratio > LARGEST_RATIO ? min(ceil(log2(ratio / LARGEST_RATIO)), 12.0) : 0.0;
            float first = closed ? reach * exp2(-doublings) : size / float(1u << round);
            float at = 0.0;
            for (uint step = 0u; step < MOST_STEPS && at < reach; step++) {
                float next = closed ? min(max(first, GROWTH * at), at + longest) : at + first;
                if (step + 1u == MOST_STEPS || next > 0.999 * reach) next = reach;
                float middle = from + towards * 0.5 * (at + next) + 0.5 * (piece.x + piece.y);
                float extent = 0.5 * (next - at);
                at = next;
                bool midpoint = how.integral == INTEGRAL_MIDPOINT;
                vec2 moments = closed ? inverse_moments(area_round(c, middle), extent, floor_area) : vec2(0.0);
                for (uint node = 0u; node < (midpoint ? 1u : 2u); node++) {
                    float place = midpoint ? 0.0 : (node == 0u ? -1.0 : 1.0) * extent * INVERSE_ROOT_3;
                    float weight;
                    if (closed) {
                        weight = 0.5 * (moments.x + moments.y * place / (extent * extent * INVERSE_ROOT_3 * INVERSE_ROOT_3));
                    } else {
                        float area = area_over(area_round(c, middle), place);
                        weight = (midpoint ? 2.0 : 1.0) * extent / max(area, floor_area);
                    }
                    sum += weight * scattered_at(push, beam, s, c, middle + place);
                }
            }
        }
        if (mean(abs(sum - before)) <= ADAPTED * mean(sum)) break;
        before = sum;
    }
    return sum;
}

// The part of a stretch that can be bright.
vec2 seen_part(Stretch s) {
    vec2 part = dense_part(s.medium, s.origin, s.direction, s.extent);
    if (media[s.medium].grid == NO_GRID) {
        vec3 lost = extinction(s.medium);
        part.y = min(part.y, DARK_DEPTH / max(min(lost.x, min(lost.y, lost.z)), 1e-20));
    }
    return part;
}
