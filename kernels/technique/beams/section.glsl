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

// Of a triangle's sides: no point inside is farther from a corner than the longest is long. Where a beam is focused its
// barycentrics are noise, which alone would see points inside from far away.
bool is_within_reach(vec3 to_corner, vec3 sides[3]) {
    float longest = max(dot(sides[0], sides[0]), max(dot(sides[1], sides[1]), dot(sides[2], sides[2])));
    return dot(to_corner, to_corner) <= 1.01 * longest;
}

// False outside of the triangle, and where it has no area.
bool section_at(Beam beam, vec3 point, out Section section) {
    vec3 from = point - beam.corners[0].origin;
    float y = dot(beam.normal, from);
    // From the point to the corners, and from corner to corner, each from its own differences: the products of the first
    // with the second lose less than products of the first, which are large where the triangle is small and far away.
    vec3 to[3], sides[3];
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner a = beam.corners[i];
        BeamCorner b = beam.corners[(i + 1u) % 3u];
        to[i] = a.origin - beam.corners[0].origin + y * a.way - from;
        sides[i] = b.origin - a.origin + y * (b.way - a.way);
    }
    vec3 parts = vec3(dot(beam.normal, cross(to[1], sides[1])), dot(beam.normal, cross(to[2], sides[2])),
                      dot(beam.normal, cross(to[0], sides[0])));
    float whole = parts.x + parts.y + parts.z;
    section.y = y;
    section.weights = parts / whole;
    section.area = 0.5 * dot(beam.normal, cross(sides[0], sides[1]));
    section.way = section.weights.x * beam.corners[0].way + section.weights.y * beam.corners[1].way +
                  section.weights.z * beam.corners[2].way;
    // False for the NaN of a beam without area, too.
    bool inside = min(section.weights.x, min(section.weights.y, section.weights.z)) >= 0.0;
    return inside && is_within_reach(to[0], sides);
}

// m2, signed.
float section_area(Beam beam, float y) {
    vec3 b = beam.corners[1].origin - beam.corners[0].origin + y * (beam.corners[1].way - beam.corners[0].way);
    vec3 c = beam.corners[2].origin - beam.corners[0].origin + y * (beam.corners[2].way - beam.corners[0].way);
    return 0.5 * dot(beam.normal, cross(b, c));
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
