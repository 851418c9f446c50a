// How much of a medium of uneven density is between a stretch's origin and places on it, at places that all beams share:
// smoke 6 m across takes hundreds of look-ups to walk through, and a pixel meets hundreds of beams in it.

const uint SEEN_PLACES = 32u;

// Of each invocation of 64, m of density 1; read by itself alone.
shared float seen_depths[SEEN_PLACES * 64u];
vec2 seen_ends; // m along the stretch: the first place, and from place to place

void note_depths(Stretch s) {
    if (s.medium == NO_MEDIUM || media[s.medium].grid == NO_GRID) return;
    vec2 part = dense_part(s.medium, s.origin, s.direction, s.extent);
    seen_ends = vec2(part.x, max(part.y - part.x, 0.0) / float(SEEN_PLACES));
    float depth = 0.0;
    for (uint i = 0u; i < SEEN_PLACES; i++) {
        seen_depths[i * 64u + gl_LocalInvocationIndex] = depth;
        vec3 from = s.origin + (part.x + float(i) * seen_ends.y) * s.direction;
        depth += density_along(s.medium, from, s.direction, seen_ends.y);
    }
}

float seen_through(Stretch s, float distance) {
    if (media[s.medium].grid == NO_GRID) return distance;
    float places = (distance - seen_ends.x) / max(seen_ends.y, 1e-20);
    uint place = uint(clamp(places, 0.0, float(SEEN_PLACES - 1u)));
    float at = seen_ends.x + float(place) * seen_ends.y;
    float before = seen_depths[place * 64u + gl_LocalInvocationIndex];
    return before + density_along(s.medium, s.origin + at * s.direction, s.direction, max(distance - at, 0.0));
}
