// What a ray of a light's or camera's view meets first in one layer: the triangle that light/visibility drew, where the ray
// meets it, else what tracing finds.
#include "shared/light_view.glsl"
#include "shared/meets.glsl"
#include "trace/interface.glsl"

struct Seen {
    uint instance; // NO_INSTANCE: nothing
    uint primitive;
    vec2 barycentrics;
};

// `drawn`: instance + 1, 0 for nothing, and primitive; of no account where nothing was rastered.
Seen first_seen(bool rastered, uvec2 drawn, uint layer, vec3 origin, vec3 direction) {
    if (rastered) {
        Seen seen = Seen(drawn.x - 1u, drawn.y, vec2(0.0)); // wraps to NO_INSTANCE
        if (seen.instance == NO_INSTANCE) return seen;
        if (meets(seen.instance, seen.primitive, origin, direction, seen.barycentrics)) return seen;
    }
    Hit hit = trace_closest(Ray(origin, 0.0, direction, 1e30), layer == LIGHT_SPECULAR ? MASK_SPECULAR : MASK_DIFFUSE);
    return Seen(hit.instance, hit.primitive, hit.barycentrics);
}
