// What a beam scatters into a stretch of a camera path, its shadow included.
#include "technique/beams/inscatter.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/tally_names.glsl"

// Who includes this counts.
void count(uint what);

// W/(m2 sr) at the camera.
vec3 volume_light(ShadePush shade, VolumePush volume, Beam beam, Stretch s) {
    if (beam.medium != s.medium) return vec3(0.0);
    count(TALLY_TESTS);
    Crossing c = crossing_of(beam, s.origin, s.direction, s.extent);
    vec2 part = part_between_ends(beam, c, s.origin, s.direction, s.extent);
    vec2 seen = seen_part(s) - c.centre;
    part = vec2(max(part.x, seen.x), min(part.y, seen.y));
    bool by_plane = volume.scan_plane != 0u;
    if (by_plane) part = scan_plane_part(beam, c, s.origin, s.direction, part);
    vec3 sum = vec3(0.0);
    float from = part.x;
    for (uint piece = 0u; piece < MOST_PIECES && from < part.y; piece++) {
        vec2 between = vec2(from, by_plane ? part.y : min(next_side(c, from), part.y));
        from = between.y;
        float middle = 0.5 * (between.x + between.y);
        if (!by_plane && !is_inside(beam, c, s.origin, s.direction, middle)) continue;
        count(TALLY_FRAGMENTS);
        if ((beam.flags & BEAM_STRADDLES) != 0u) {
            Section section = section_along(beam, c, middle);
            vec3 point = s.origin + (c.centre + middle) * s.direction;
            float before = section.y - dot(section.weights, beam_starts(beam));
            count(TALLY_RAYS);
            if (before > 0.0 && is_shadowed(beam, point, point - before * section.way)) {
                count(TALLY_SHADOWED);
                continue;
            }
        }
        vec3 found = piece_integral(shade, volume, beam, s, c, between) * beam.flux * s.throughput;
        if (all_finite(found)) {
            sum += found;
        } else {
            count(TALLY_NON_FINITE);
        }
    }
    return sum;
}
