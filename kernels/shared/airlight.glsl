// Where on a stretch of a camera path the light of one lamp that a medium scatters into it is looked for: near the lamp,
// and where the medium still lets light through to the camera. Any choice of places is unbiased; these keep noise low.
#include "shared/media.glsl"
#include "shared/optics.glsl"

// Part of a line within a spot light's cone, m from `origin`; the first is not below the second where there is none.
vec2 part_in_cone(Light light, vec3 origin, vec3 direction, float length) {
    if (light.kind != LIGHT_SPOT) return vec2(0.0, length);
    // From the line's point next to the light on, where the quadratic's discriminant does not cancel.
    float nearest = dot(light.position - origin, direction);
    vec3 side = origin + nearest * direction - light.position;
    float along = dot(direction, light.direction);
    float ahead = dot(side, light.direction);
    float distance2 = dot(side, side);
    // Widened a little: rounding must not cut light off.
    float cosine = max(light.cos_outer - 1e-4, 0.0);
    float a = along * along - cosine * cosine;
    float b = ahead * along;
    float c = ahead * ahead - cosine * cosine * distance2;
    float discriminant = cosine * cosine * (ahead * ahead + distance2 * a);
    if (discriminant < 0.0) return vec2(0.0);
    float q = -(b + (b < 0.0 ? -sqrt(discriminant) : sqrt(discriminant)));
    float first = q / (abs(a) < 1e-20 ? 1e-20 : a);
    float second = abs(q) > 0.0 ? c / q : 0.0;
    vec2 roots = vec2(min(first, second), max(first, second));
    vec2 part;
    if (a > 0.0) {
        // Into the cone or out of it, once; the other root is on the cone's mirror image behind the light.
        part = along > 0.0 ? vec2(roots.y, ENDLESS) : vec2(-ENDLESS, roots.x);
    } else {
        part = ahead + 0.5 * (roots.x + roots.y) * along >= 0.0 ? roots : vec2(0.0);
    }
    return clamp(part + nearest, 0.0, length);
}

// 1 - exp(-x), without cancellation.
float absorbed_part(float x) {
    return x < 0.01 ? x * (1.0 - x * (0.5 - x / 6.0)) : 1.0 - exp(-x);
}

// -log(1 - x), without cancellation.
float depth_of_part(float x) {
    return x < 0.01 ? x * (1.0 + x * (0.5 + x / 3.0)) : -log(max(1.0 - x, 1e-30));
}

// Places with a density as 1 / (apart + |t - nearest|)^2, which the light's 1 / distance^2 differs from by a factor of 2 at
// most. Kulla and Fajardo's equiangular places (2012) follow it exactly, but take an arc tangent and a tangent, which
// devices may round coarsely; stratified, these are as good.
struct NearLight {
    float nearest; // m from the start, of the point next to the light
    float apart;   // m, of that point from the light
    float first;   // t - nearest at both ends
    float last;
    float below;   // integral over the part before `nearest`, and over the part behind
    float above;
};

NearLight near_light(vec3 light, vec3 origin, vec3 direction, float length) {
    NearLight n;
    n.nearest = dot(light - origin, direction);
    // Any distance will do where the light is on the line itself.
    n.apart = max(distance(light, origin + n.nearest * direction), 1e-6 * length);
    n.first = -n.nearest;
    n.last = length - n.nearest;
    float low = max(-n.last, 0.0);
    float high = max(-n.first, 0.0);
    n.below = (high - low) / ((n.apart + low) * (n.apart + high));
    low = max(n.first, 0.0);
    high = max(n.last, 0.0);
    n.above = (high - low) / ((n.apart + low) * (n.apart + high));
    return n;
}

// m from the start, for `random` in [0, 1).
float place_near(NearLight n, float random) {
    float mass = random * (n.below + n.above);
    float offset;
    if (mass < n.below) {
        offset = n.apart - 1.0 / (mass + 1.0 / (n.apart + max(-n.first, 0.0)));
    } else {
        float start = n.apart + max(n.first, 0.0);
        offset = start / max(1.0 - (mass - n.below) * start, 1e-30) - n.apart;
    }
    return n.nearest + clamp(offset, n.first, n.last);
}

// 1/m.
float density_near(NearLight n, float t) {
    float size = n.apart + abs(t - n.nearest);
    return 1.0 / ((n.below + n.above) * size * size);
}

// The part of a stretch that one light can reach.
struct Airlight {
    vec3 origin;
    vec3 direction;
    float extent;     // m
    uint medium;
    vec3 throughput;  // radiance at the camera over that at `origin`
    float extinction; // 1/m, where density is 1, mean of the channels
    float depth;      // metres of density 1
    float flights;    // part of the places that is chosen by how much light comes through to the camera
    NearLight near;
};

struct Place {
    vec3 position;
    vec3 to_light;
    float distance; // to the light, m
    vec3 radiance;  // at the camera, over the density of places; the way to the light is left to the caller
};

// False where no light comes from it.
bool airlight(Light light, vec3 origin, vec3 direction, float length, uint medium, vec3 throughput, out Airlight air) {
    vec2 part = part_in_cone(light, origin, direction, length);
    vec2 dense = dense_part(medium, origin, direction, length);
    part = vec2(max(part.x, dense.x), min(part.y, dense.y));
    if (!(part.x < part.y)) return false;
    air.origin = origin + part.x * direction;
    air.direction = direction;
    air.extent = part.y - part.x;
    air.medium = medium;
    air.throughput = throughput * transmittance(medium, origin, direction, part.x);
    air.extinction = mean(extinction(medium));
    air.depth = density_along(medium, air.origin, direction, air.extent);
    if (mean(air.throughput) <= 0.0 || air.depth <= 0.0) return false;
    // In a thin medium of even density flights would only take places away from the light.
    bool even = media[medium].grid == NO_GRID;
    air.flights = even ? 0.5 * absorbed_part(air.extinction * air.depth) : 0.5;
    if (light.kind != LIGHT_DIRECTIONAL) air.near = near_light(light.position, air.origin, direction, air.extent);
    return true;
}

Place airlight_place(Airlight air, Light light, float random) {
    float lost = absorbed_part(air.extinction * air.depth);
    float stop = air.extent;
    float target = ENDLESS;
    if (random < air.flights) {
        target = depth_of_part(random / air.flights * lost) / air.extinction;
    } else {
        float rest = (random - air.flights) / (1.0 - air.flights);
        stop = light.kind == LIGHT_DIRECTIONAL ? rest * air.extent : place_near(air.near, rest);
    }
    March there = march(air.medium, air.origin, air.direction, air.extent, stop, target);
    float by_flight = there.mean * air.extinction * exp(-air.extinction * there.even) / lost;
    float by_light = light.kind == LIGHT_DIRECTIONAL ? 1.0 / air.extent : density_near(air.near, there.at);
    float density = mix(by_light, by_flight, air.flights);

    Place place;
    place.position = air.origin + there.at * air.direction;
    LightSample seen = light_at(light, place.position);
    place.to_light = seen.to_light;
    place.distance = seen.distance;
    vec3 scattered = media[air.medium].scattering * (there.density * phase(air.medium, dot(seen.to_light, air.direction)));
    vec3 left = exp(-extinction(air.medium) * there.depth);
    place.radiance = air.throughput * left * scattered * seen.irradiance / density;
    return place;
}
