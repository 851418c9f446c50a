// Sends photons from the lights through the cells that specular objects fill, and follows each through S+ to the first
// diffuse surface; on the way it leaves photons in media that scatter. Photon slots are fixed, so that nothing depends on
// the order of threads.
#include "technique/reference/common.glsl"
#include "technique/reference/volume.glsl"
#include "shared/media.glsl"
#include "shared/optics.glsl"
#include "shared/parts.glsl"
#include "shared/random.glsl"
#include "shared/emission.glsl"
#include "trace/interface.glsl"

layout(set = 3, binding = 2, std430) readonly buffer EmissionCells { EmissionCell emission_cells[]; };
layout(set = 3, binding = 3, std430) writeonly buffer Photons { Photon photons[]; };
layout(set = 3, binding = 4, std430) buffer Ledger { uint ledger[]; };
layout(set = 3, binding = 10, std430) writeonly buffer VolumePhotons { Photon volume_photons[]; };
layout(push_constant) uniform EmitPush {
    uint pass;
    uint cells;
    uint samples;     // a cell and pass
    uint split;       // 1: both branches of the first interface are followed, a slot each
    uint classes;     // bits of the path classes that are kept
    uint seed;
    float ledger_unit; // W
    uint slots;
    uint volume_classes; // as `classes`, of photons in volumes
    uint volume_points;  // photons that a path leaves in volumes; 0 where no medium scatters
} push;

// Of the shading normal's cosine to the geometric one's: a bound for light that grazes a face.
const float MAX_COSINE_RATIO = 8.0;

// Photons that meet more specular surfaces are given up and counted.
const uint MAX_EVENTS = 32u;

// Entries of the ledger, two words each.
const uint LANDED = 0u;
const uint ABSORBED = 1u;
const uint SCATTERED = 2u;
const uint ESCAPED = 3u;
const uint UNFOCUSED = 4u;  // met a diffuse surface first: direct light
const uint GIVEN_UP = 5u;
const uint OTHER_CLASS = 6u;
const uint WRONG_SIDE = 7u;
const uint NON_FINITE = 8u;

void book(uint entry, vec3 flux) {
    uint amount = uint(clamp(mean(flux) / push.ledger_unit + 0.5, 0.0, 4.0e9));
    uint before = atomicAdd(ledger[2u * entry], amount);
    if (before + amount < before) atomicAdd(ledger[2u * entry + 1u], 1u);
}

// The bit of a path by how often it was refracted and reflected.
uint path_class(uint refractions, uint reflections) {
    if (reflections == 0u) return refractions == 1u ? 1u : 2u;
    if (refractions == 0u) return reflections == 1u ? 4u : 8u;
    return 16u;
}

// What becomes of one photon; `kept` is the stretch on which it leaves photons in volumes.
void follow(uint slot, EmissionCell cell, uint index, uint seed, inout Kept kept) {
    bool second_branch = push.split != 0u && (slot & 1u) != 0u;
    vec3 origin, direction, flux;
    emit(cell, lights[cell.light], sample_2d(index, seed), origin, direction, flux);
    flux /= float(push.samples);
    uint medium = lights[cell.light].medium;
    uint refractions = 0u;
    uint reflections = 0u;
    if (lights[cell.light].kind == LIGHT_DIRECTIONAL) {
        // It has come through all of the medium that lies before the plane on which its photons start.
        vec3 left = flux * transmittance(medium, origin, -direction, FAR_AWAY);
        vec3 scattered = (flux - left) * scattered_part(medium);
        if (!second_branch) {
            book(SCATTERED, scattered);
            book(ABSORBED, flux - left - scattered);
        }
        flux = left;
    }

    for (uint event = 0u; event <= MAX_EVENTS; event++) {
        Hit hit = trace_closest(Ray(origin, 0.0, direction, 1e30), MASK_ALL);
        bool first = event == 0u;
        bool booked = !(first && second_branch); // by the other branch
        bool escapes = hit.instance == NO_INSTANCE;
        Surface s;
        float way = view.reach;
        if (!escapes) {
            s = surface_at(hit.instance, hit.primitive, hit.barycentrics);
            way = length(s.position - origin);
        }
        vec3 left = flux * transmittance(medium, origin, direction, way);
        vec3 scattered = (flux - left) * scattered_part(medium);
        if (booked) {
            book(SCATTERED, scattered);
            book(ABSORBED, flux - left - scattered);
        }
        if (!first && push.volume_points > 0u && (path_class(refractions, reflections) & push.volume_classes) != 0u) {
            float chance = sample_1d(index, combine(seed, KEEP_SEED + event));
            keep(kept, Kept(origin, way, direction, medium, flux, mean(scattered), 0.0), chance);
        }
        flux = left;
        if (escapes) {
            if (booked) book(ESCAPED, flux);
            return;
        }
        uint kind = materials[s.material].kind;
        if (!booked && kind != MATERIAL_DIELECTRIC) return;
        if (kind == MATERIAL_DIFFUSE) {
            bool front = dot(direction, s.geometric) < 0.0;
            if (first) {
                book(UNFOCUSED, flux);
            } else if ((path_class(refractions, reflections) & push.classes) == 0u) {
                book(OTHER_CLASS, flux);
            } else if (!all_finite(flux) || !all_finite(s.position)) {
                book(NON_FINITE, vec3(push.ledger_unit));
            } else {
                book(LANDED, flux);
                // The estimate is flux over area, which carries the geometric cosine; irradiance, like direct light's,
                // goes by the shading normal's.
                float shading = dot(direction, s.shading) / dot(direction, s.geometric);
                flux *= clamp(shading, 0.0, MAX_COSINE_RATIO);
                photons[slot] = Photon(s.position, pack_direction(front ? s.shading : -s.shading), flux, 1u);
            }
            return;
        }
        if (event == MAX_EVENTS) break;
        vec3 before = direction;
        bool crosses = false;
        if (kind == MATERIAL_DIELECTRIC) {
            Interface i = interface_at(s, direction);
            bool reflects;
            if (first && push.split != 0u) {
                reflects = second_branch;
                flux *= reflects ? i.reflectance : 1.0 - i.reflectance;
                if (mean(flux) <= 0.0) return;
            } else {
                reflects = sample_1d(index, combine(seed, event + 1u)) < i.reflectance;
            }
            if (reflects) {
                direction = reflected(i, direction);
                reflections++;
            } else {
                direction = refracted(i, direction);
                medium = i.beyond;
                crosses = true;
                refractions++;
            }
        } else {
            vec3 weight = vec3(0.0);
            if (kind == MATERIAL_MIRROR) {
                direction = normalize(reflect(direction, dot(direction, s.geometric) < 0.0 ? s.shading : -s.shading));
                weight = materials[s.material].color;
            } else if (HAS_ROUGH) {
                direction = reflect_rough(s, direction, sample_2d(index, combine(seed, event + 1u)), weight);
            }
            book(ABSORBED, flux * (1.0 - weight));
            flux *= weight;
            if (mean(flux) <= 0.0) return;
            reflections++;
        }
        if (!stays_on_side(s, before, direction, crosses)) {
            book(WRONG_SIDE, flux);
            return;
        }
        origin = leave(s, direction);
    }
    book(GIVEN_UP, flux);
}

void main() {
    uint slot = linear_index();
    if (slot >= push.slots) return;
    photons[slot] = no_photon();
    uint ray = push.split != 0u ? slot / 2u : slot;
    uint cell_index = ray / push.samples;
    uint index = push.pass * push.samples + ray % push.samples;
    uint seed = combine(push.seed, cell_index);
    Kept kept = nothing_kept();
    follow(slot, emission_cells[cell_index], index, seed, kept);
    for (uint point = 0u; point < push.volume_points; point++) {
        float random = sample_1d(index, combine(seed, POINT_SEED + point));
        volume_photons[slot * push.volume_points + point] = photon_on(kept, point, push.volume_points, random);
    }
}
