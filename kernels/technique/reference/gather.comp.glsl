// Gathers the pass's photons round each visible point and shrinks its radius (Hachisuka and Jensen 2009, Eqs. 2-5).
#include "technique/reference/common.glsl"
#include "technique/reference/sum.glsl"
#include "shared/film.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };
layout(set = 3, binding = 1, std430) buffer Statistics { Statistic statistics[]; };
layout(set = 3, binding = 5, std430) readonly buffer BucketStarts { uint bucket_starts[]; };
layout(set = 3, binding = 7, std430) readonly buffer SortedPhotons { Photon sorted_photons[]; };
layout(set = 3, binding = 9, std430) buffer HalfFluxes { float half_fluxes[]; };
layout(push_constant) uniform GatherPush {
    uint slots;
    uint buckets;
    float alpha;      // of the photons gathered in a pass, the part that is kept
    float flux_unit;  // W; what the integer sums count
    uint odd;         // whether this pass belongs to the half of passes kept apart for the error estimate
} push;

// A photon on a surface turned by more than 60 degrees belongs to another surface, over an edge or through a thin wall.
const float MIN_NORMAL_COSINE = 0.5;

void main() {
    uint slot = linear_index();
    if (slot >= view.width * view.rows * VISIBLE_LAYERS) return;
    VisiblePoint point = visible_points[slot];
    Statistic statistic = statistics[slot];
    if (point.instance == NO_INSTANCE || statistic.radius2 == 0.0) return;
    vec3 normal = unpack_direction(point.normal);
    float size = cell_size();
    float radius = sqrt(statistic.radius2);
    ivec3 low = cell_of(point.position - radius, size);
    ivec3 extent = min(cell_of(point.position + radius, size) - low + 1, ivec3(CELLS_PER_AXIS));
    uint cells = uint(extent.x * extent.y * extent.z);

    Sum sum = empty_sum();
    uint photons = 0u;
    for (uint c = 0u; c < cells; c++) {
        ivec3 step = ivec3(int(c) % extent.x, (int(c) / extent.x) % extent.y, int(c) / (extent.x * extent.y));
        ivec3 cell = low + step;
        uint bucket = bucket_of(cell, push.buckets);
        uint last = min(bucket_starts[bucket + 1u], push.slots);
        for (uint index = bucket_starts[bucket]; index < last; index++) {
            Photon photon = sorted_photons[index];
            vec3 way = photon.position - point.position;
            if (dot(way, way) > statistic.radius2) continue;
            // Several cells share a bucket; each photon counts in its own cell only.
            if (any(notEqual(cell_of(photon.position, size), cell))) continue;
            if (dot(unpack_direction(photon.normal), normal) < MIN_NORMAL_COSINE) continue;
            add(sum, photon.flux / push.flux_unit);
            photons++;
        }
    }
    if (photons == 0u) return;
    float gathered = float(photons);
    float shrink = (statistic.photons + push.alpha * gathered) / (statistic.photons + gathered);
    vec3 flux = total(sum) * push.flux_unit;
    VisibleShade shade = visible_shades[slot];
    vec3 radiance_flux = flux * shade.throughput * shade.albedo / PI;
    if (!all_finite(radiance_flux)) {
        atomicAdd(counters.non_finite, 1u);
        return;
    }
    statistic.irradiance_flux = (statistic.irradiance_flux + flux) * shrink;
    statistic.radiance_flux = (statistic.radiance_flux + radiance_flux) * shrink;
    statistic.photons += push.alpha * gathered;
    statistic.radius2 *= shrink;
    statistics[slot] = statistic;
    half_fluxes[slot] = (half_fluxes[slot] + (push.odd != 0u ? mean(flux) : 0.0)) * shrink;
}
