// Whether the way between a point and the start of the light's last stretch is free.
#include "trace/interface.glsl"
#include "technique/beams/section.glsl"

const uint SHADOW_POINTS = 0u; // every point looks for itself
const uint SHADOW_EDGES = 1u;  // what the edges found holds between them, where they end on one smooth surface

// Metres from the starts' plane within which a specular surface is the one that the light comes from: it bends away
// between the corners.
float start_width(Beam beam) {
    vec3 at[3];
    for (uint i = 0u; i < 3u; i++) at[i] = beam.corners[i].origin + beam.corners[i].start * beam.corners[i].way;
    return max(distance(at[0], at[1]), max(distance(at[1], at[2]), distance(at[2], at[0])));
}

bool wants_ray(Beam beam, Section section, uint shadows) {
    if (shadows == SHADOW_POINTS || (beam.flags & BEAM_STRADDLES) != 0u) return true;
    float end = dot(section.weights, beam_ends(beam));
    return section.y > end + BEYOND * (end - dot(section.weights, beam_starts(beam)));
}

bool is_shadowed(Beam beam, vec3 point, vec3 start) {
    Hit hit = trace_closest(Ray(point, 0.0, start - point, 1.0), MASK_ALL);
    if (hit.instance == NO_INSTANCE) return false;
    bool own = (instances[hit.instance].mask & MASK_SPECULAR) != 0u;
    return !own || (1.0 - hit.t) * distance(start, point) > start_width(beam);
}
