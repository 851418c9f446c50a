// What a beam scatters into a stretch of a camera path, step by step.
#include "technique/beams/inscatter.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/tally_names.glsl"

// Who includes this counts.
void count(uint what);

// The part of the stretch between the beam's ends, t.
vec2 beam_part(VolumePush volume, Beam beam, Stretch s, vec2 seen, Crossing c) {
    vec2 part = part_between_ends(beam, c, s.origin, s.direction, s.extent);
    part = vec2(max(part.x, seen.x - c.centre), min(part.y, seen.y - c.centre));
    return volume.scan_plane != 0u ? scan_plane_part(beam, c, s.origin, s.direction, part) : part;
}

vec2 piece_from(VolumePush volume, Crossing c, vec2 part, float from) {
    return volume.scan_plane != 0u ? vec2(max(part.x, from), part.y) : next_inside(c, part, from);
}

// Whether a beam is of the stretch's medium and may meet it.
bool may_light(Beam beam, Stretch s) {
    return beam.medium == s.medium && may_meet(beam, s.origin, s.direction, s.extent);
}

// Whether something is in the light's way to where the ray is first inside a beam that ends on different surfaces.
bool is_hidden(VolumePush volume, Beam beam, Stretch s, vec2 seen) {
    Crossing c = crossing_of(beam, s.origin, s.direction, s.extent);
    vec2 part = beam_part(volume, beam, s, seen, c);
    vec2 piece = piece_from(volume, c, part, -ALL_DONE);
    if (!(piece.x < piece.y)) return true;
    float middle = 0.5 * (piece.x + piece.y);
    Section section = section_along(beam, c, middle);
    float before = section.y - dot(section.weights, beam_starts(beam));
    if (before <= 0.0) return false;
    count(TALLY_RAYS);
    vec3 point = s.origin + (c.centre + middle) * s.direction;
    if (!is_shadowed(beam, point, point - before * section.way)) return false;
    count(TALLY_SHADOWED);
    return true;
}

// The next step's W/(m2 sr) at the camera; `from` starts at -ALL_DONE and is at ALL_DONE after the last. `seen` is the
// stretch's seen_part(). A step at a time, and each from its beginning: software drivers run both ways of every branch, and
// every loop's body once too often, so that loops within loops would cost many times what they do.
vec3 volume_step(ShadePush shade, VolumePush volume, uint index, Beam beam, Stretch s, vec2 seen, inout float from) {
    Crossing c = crossing_of(beam, s.origin, s.direction, s.extent);
    vec2 part = beam_part(volume, beam, s, seen, c);
    vec2 piece = piece_from(volume, c, part, from);
    bool first = from < piece.x;
    from = ALL_DONE;
    if (!(piece.x < piece.y)) return vec3(0.0);
    bool noise = volume.scan_plane == 0u && !is_within_beam(beam, c, s.origin, s.direction, 0.5 * (piece.x + piece.y));
    float least = (part.y - part.x) / MOST_STEPS;
    float end = noise ? piece.y : step_from(volume, beam, c, piece.x, piece.y, least);
    if (!(end > piece.x)) end = piece.y; // less than rounding
    if (end < part.y) from = end;
    if (noise) return vec3(0.0);
    if (first) count(TALLY_FRAGMENTS);
    vec3 found = step_integral(shade, volume, index, beam, s, c, vec2(piece.x, end)) * beam.flux * s.throughput;
    if (all_finite(found)) return found;
    count(TALLY_NON_FINITE);
    return vec3(0.0);
}
