// Photons in volumes. Of the stretches of its path that lie in media which scatter, a photon keeps one by chance, and
// leaves photons there that carry what is scattered. The path itself loses light by extinction, never by chance.
#include "shared/media.glsl"

// Apart from the numbers of events, which seed what happens at surfaces.
const uint KEEP_SEED = 1024u;
const uint POINT_SEED = 2048u;

struct Kept {
    vec3 origin;
    float extent;   // m
    vec3 direction; // unit, the way that the light goes
    uint medium;
    vec3 flux;      // W at `origin`
    float power;    // W scattered along the stretch, mean of the channels
    float total;    // of all stretches so far
};

Kept nothing_kept() {
    return Kept(vec3(0.0), 0.0, vec3(0.0), 0u, vec3(0.0), 0.0, 0.0);
}

Photon no_photon() {
    return Photon(vec3(0.0), 0u, vec3(0.0), 0u);
}

// A reservoir of one: in the end each stretch has been kept with a probability that is its share of the power.
void keep(inout Kept kept, Kept next, float chance) {
    if (!(next.power > 0.0) || !all_finite(next.flux)) return;
    next.total = kept.total + next.power;
    if (chance * next.total < next.power) {
        kept = next;
    } else {
        kept.total = next.total;
    }
}

// Below, an exponential is a straight line to 1e-3, and its inverse cancels.
const float THIN = 1e-3;

// Photon `point` of `points` on the stretch. One half is spread evenly over it, the other as if extinction were the same
// all along it; the balance heuristic weighs both, so that neither thick media nor dense spots behind thin ones give rare
// and heavy photons.
Photon photon_on(Kept kept, uint point, uint points, float random) {
    if (!(kept.power > 0.0)) return no_photon();
    vec2 part = dense_part(kept.medium, kept.origin, kept.direction, kept.extent);
    float size = part.y - part.x;
    if (!(size > 0.0)) return no_photon();
    float depth = mean(extinction(kept.medium)) * density_along(kept.medium, kept.origin, kept.direction, kept.extent);
    float at = 2.0 * (float(point) + random) / float(points);
    float left = exp(-depth);
    float u = at < 1.0 ? at : at - 1.0;
    if (at >= 1.0 && depth > THIN) u = min(-log(1.0 - u * (1.0 - left)) / depth, 1.0);
    float density = depth > THIN ? 0.5 + 0.5 * depth * exp(-depth * u) / (1.0 - left) : 1.0;
    float distance = part.x + u * size;
    vec3 position = kept.origin + distance * kept.direction;
    vec3 flux = kept.flux * transmittance(kept.medium, kept.origin, kept.direction, distance);
    flux *= scattering_at(kept.medium, position) * size / density / float(points) * (kept.total / kept.power);
    if (!all_finite(flux) || !all_finite(position) || mean(flux) <= 0.0) return no_photon();
    return Photon(position, pack_direction(kept.direction), flux, 1u + kept.medium);
}
