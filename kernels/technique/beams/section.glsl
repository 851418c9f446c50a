// Cross-sections of a beam. The plane of equal y through a point cuts the edges in a triangle, whose signed area changes
// sign where the beam focuses (erratum 8).
#include "shared/math.glsl"
#include "technique/beams/beam.glsl"

struct Section {
    float y;
    vec3 weights; // barycentrics of the point; all in [0, 1] inside the beam
    float area;   // m2, signed
    vec3 way;     // of the light through the point; its component along the beam's normal is 1
};

// False outside of the triangle, and where it has no area.
bool section_at(Beam beam, vec3 point, out Section section) {
    vec3 from = point - beam.corners[0].origin;
    float y = dot(beam.normal, from);
    // From the point to the corners: no difference of large numbers is left in what follows.
    vec3 a = y * beam.corners[0].way - from;
    vec3 b = beam.corners[1].origin - beam.corners[0].origin + y * beam.corners[1].way - from;
    vec3 c = beam.corners[2].origin - beam.corners[0].origin + y * beam.corners[2].way - from;
    vec3 parts = vec3(dot(beam.normal, cross(b, c)), dot(beam.normal, cross(c, a)), dot(beam.normal, cross(a, b)));
    float whole = parts.x + parts.y + parts.z;
    section.y = y;
    section.weights = parts / whole;
    section.area = 0.5 * whole;
    section.way = section.weights.x * beam.corners[0].way + section.weights.y * beam.corners[1].way +
                  section.weights.z * beam.corners[2].way;
    // False for the NaN of a beam without area, too.
    return abs(whole) > 0.0 && min(section.weights.x, min(section.weights.y, section.weights.z)) >= 0.0;
}

vec3 beam_starts(Beam beam) {
    return vec3(beam.corners[0].start, beam.corners[1].start, beam.corners[2].start);
}

vec3 beam_ends(Beam beam) {
    return vec3(beam.corners[0].end, beam.corners[1].end, beam.corners[2].end);
}

// A receiver may bend away between the edges: points this part of the beam's length beyond its end are its own, too, if
// light gets there.
const float BEYOND = 0.05;

// The y between which a beam lights surfaces.
vec2 beam_range(Beam beam) {
    vec3 starts = beam_starts(beam);
    vec3 ends = beam_ends(beam);
    float low = min(starts.x, min(starts.y, starts.z));
    float high = max(ends.x, max(ends.y, ends.z));
    return vec2(low, high + BEYOND * (high - low));
}

bool beam_is_finite(Beam beam) {
    bool finite = all_finite(beam.normal);
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner corner = beam.corners[i];
        finite = finite && all_finite(corner.origin) && all_finite(corner.way) &&
                 all_finite(vec3(corner.start, corner.end, 0.0));
    }
    return finite;
}

// A box round the beam between two planes of equal y: the edges are straight, so their ends do.
void box_of_range(Beam beam, vec2 range, out vec3 low, out vec3 high) {
    low = vec3(3e38);
    high = vec3(-3e38);
    for (uint i = 0u; i < 3u; i++) {
        vec3 first = beam.corners[i].origin + range.x * beam.corners[i].way;
        vec3 last = beam.corners[i].origin + range.y * beam.corners[i].way;
        low = min(low, min(first, last));
        high = max(high, max(first, last));
    }
}
