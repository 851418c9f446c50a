// Light that photons in volumes scatter towards the camera: each stretch of a camera path sums the photons within a radius
// of it, the beam radiance estimate (Jarosz, Zwicker and Jensen 2008). The radius is the same everywhere and shrinks from
// set to set of photons (Knaus and Zwicker 2011).
#include "technique/reference/common.glsl"
#include "technique/reference/sum.glsl"
#include "shared/film.glsl"
#include "shared/media.glsl"
#include "shared/segments.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 19, std430) buffer FilmCausticVolume { vec4 film_caustic_volume[]; };
layout(set = 3, binding = 5, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 7, std430) readonly buffer SortedPhotons { Photon sorted_photons[]; };
layout(push_constant) uniform GatherVolumePush {
    uint slots;
    uint buckets;
    float radius;    // m
    float flux_unit; // W; what the integer sums count
    uint index;      // samples before this one
} push;

// A cylinder that is cut off where its axis meets a surface lacks what lies between the cut and the surface on one side,
// and on the other has as much within the surface, where no photon is. Running on until it is through, it has all of the
// light, to first order in the radius. Beyond these many radii the axis grazes the surface.
const float MAX_BEYOND_POINT = 8.0;
// Of surfaces that refract or mirror, the normal is not known; refracted rays are rarely flatter than 63 degrees.
const float BEYOND_SPECULAR = 2.0;

// Cells are two to four radii wide, and a slab of them cuts out of the cylinder at most 1 + 2.83 / 2 cells across an axis.
const int MOST_ACROSS = 4;
const float MOST_SLABS = 1e6;

struct Beam { // a stretch as photons see it
    Stretch s;
    float from;        // m along the stretch: photons count whose feet lie from here
    float to;          // to here
    vec3 plane;        // normal of the surface at its end, towards the light; zero where there is none
};

bool near(vec3 a, vec3 b) {
    vec3 way = a - b;
    vec3 size = max(abs(a), abs(b));
    float error = 1e-5 * max(max(size.x, size.y), max(size.z, 1e-3));
    return dot(way, way) <= error * error;
}

Beam beam(Stretch s, VisiblePoint point) {
    Beam result = Beam(s, 0.0, s.extent, vec3(0.0));
    // A camera looks from within its medium; all other stretches begin at a surface.
    if (s.origin != view.position) result.from = -BEYOND_SPECULAR * push.radius;
    vec3 end = s.origin + s.extent * s.direction;
    if (point.instance != NO_INSTANCE && near(end, point.position)) {
        result.plane = unpack_direction(point.geometric);
        float cosine = clamp(-dot(result.plane, s.direction), 1e-3, 1.0);
        result.to += push.radius * min(sqrt(1.0 - cosine * cosine) / cosine, MAX_BEYOND_POINT);
    } else if (s.extent < 0.9999 * view.reach) {
        result.to += BEYOND_SPECULAR * push.radius;
    }
    if (media[s.medium].grid != NO_GRID) {
        // No photon lies where density is zero. A stretch that misses all of it has nothing to walk through.
        vec2 part = dense_part(s.medium, s.origin, s.direction, s.extent);
        if (!(part.x < part.y)) return Beam(s, 0.0, -1.0, vec3(0.0));
        result.from = max(result.from, part.x - push.radius);
        result.to = min(result.to, part.y + push.radius);
    }
    return result;
}

// The light of one photon: W/m2 sr times the area of the cylinder's cross-section. `reached` is the place on the stretch
// up to which `left` is its transmittance.
vec3 scattered(Beam b, Photon photon, float foot, float reached, vec3 left) {
    Stretch s = b.s;
    float cosine = -dot(unpack_direction(photon.normal), s.direction);
    float way = max(clamp(foot, 0.0, s.extent) - reached, 0.0);
    left *= transmittance(s.medium, s.origin + reached * s.direction, s.direction, way);
    return photon.flux * left * s.throughput * phase(s.medium, cosine);
}

// Slab by slab of cells across the axis along which the stretch runs most, each cell once.
void gather(inout Sum sum, Beam b) {
    if (b.from > b.to) return;
    Stretch s = b.s;
    float size = cell_size();
    vec3 size_of = abs(s.direction);
    uint a = size_of.x > size_of.y ? (size_of.x > size_of.z ? 0u : 2u) : (size_of.y > size_of.z ? 1u : 2u);
    vec3 slope = s.direction / s.direction[a];
    // The slab's planes cut the cylinder in ellipses; half their extent along each axis.
    vec3 half_extent = push.radius * sqrt(1.0 + slope * slope);
    // A photon's foot lies this far from it along the axis, and this far from the slab along the stretch.
    float lean = push.radius * sqrt(max(0.0, 1.0 - size_of[a] * size_of[a]));
    float margin = lean / size_of[a];

    bool up = s.direction[a] > 0.0;
    float first = s.origin[a] + b.from * s.direction[a] + (up ? -lean : lean);
    float last = s.origin[a] + b.to * s.direction[a] + (up ? lean : -lean);
    float first_cell = clamp(floor(first / size), -1e9, 1e9);
    float last_cell = clamp(floor(last / size), -1e9, 1e9);
    uint slabs = uint(min(abs(last_cell - first_cell), MOST_SLABS)) + 1u;

    float reached = 0.0;
    vec3 left = vec3(1.0);
    for (uint slab = 0u; slab < slabs; slab++) {
        int cell_a = int(first_cell) + (up ? int(slab) : -int(slab));
        float near_plane = float(up ? cell_a : cell_a + 1) * size;
        float far_plane = float(up ? cell_a + 1 : cell_a) * size;
        vec3 entry = s.origin + (near_plane - s.origin[a]) * slope;
        vec3 exit = s.origin + (far_plane - s.origin[a]) * slope;
        ivec3 low = cell_of(min(entry, exit) - half_extent, size);
        ivec3 extent = clamp(cell_of(max(entry, exit) + half_extent, size) - low + 1, ivec3(1), ivec3(MOST_ACROSS));
        low[a] = cell_a;
        extent[a] = 1;
        float start = clamp((near_plane - s.origin[a]) / s.direction[a] - margin, 0.0, s.extent);
        uint cells = uint(extent.x * extent.y * extent.z);
        for (uint c = 0u; c < cells; c++) {
            ivec3 cell = low + ivec3(int(c) % extent.x, (int(c) / extent.x) % extent.y, int(c) / (extent.x * extent.y));
            uint bucket = bucket_of(cell, push.buckets);
            uint end = min(bucket_starts[bucket + 1u], push.slots);
            for (uint index = bucket_starts[bucket]; index < end; index++) {
                Photon photon = sorted_photons[index];
                vec3 way = photon.position - s.origin;
                float foot = dot(way, s.direction);
                vec3 across = way - foot * s.direction;
                if (dot(across, across) > push.radius * push.radius || foot < b.from || foot > b.to) continue;
                // Several cells share a bucket; each photon counts in its own cell only.
                if (photon.landed != 1u + s.medium || any(notEqual(cell_of(photon.position, size), cell))) continue;
                // On the other side of a thin wall.
                if (dot(way - s.extent * s.direction, b.plane) < 0.0) continue;
                if (start > reached) {
                    left *= transmittance(s.medium, s.origin + reached * s.direction, s.direction, start - reached);
                    reached = start;
                }
                add(sum, scattered(b, photon, foot, reached, left) / push.flux_unit);
            }
        }
    }
}

void main() {
    uint slot = linear_index();
    uint slots = view.width * view.rows * VISIBLE_LAYERS;
    if (slot >= slots) return;
    VisiblePoint point = visible_points[slot];
    Sum sum = empty_sum();
    for (uint k = 0u; k < view.segments; k++) {
        Stretch s = stretch(k, slot, slots);
        if (s.medium != NO_MEDIUM) gather(sum, beam(s, point));
    }
    vec3 radiance = total(sum) * (push.flux_unit / (PI * push.radius * push.radius));
    if (!all_finite(radiance)) {
        atomicAdd(counters.non_finite, 1u);
        radiance = vec3(0.0);
    }
    film_caustic_volume[slot] += (vec4(radiance, 0.0) - film_caustic_volume[slot]) / float(push.index + 1u);
}
