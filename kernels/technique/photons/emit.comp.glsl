// Starts a set's photons where lights see something specular (Meenrattanakorn and Lambers 2023, section 3.1). One
// invocation a photon, which keeps its slot. Apart from photons/trace: together they took lavapipe's compiler twice as long
// as one after the other.
#include "shared/meets.glsl"
#include "shared/random.glsl"
#include "technique/photons/spaces.glsl"
#include "technique/photons/photon.glsl"
#include "technique/photons/fates.glsl"
#include "technique/photons/tallies.glsl"

// How a set's photons are shared out among lights' views: a grid of places over each.
struct Share {
    uint first;   // photon
    uint columns; // multiples of eight: a workgroup's photons are neighbours
    uint rows;
    float power;  // W of a photon of the mean channel, about
};

layout(set = 3, binding = 5, std430) readonly buffer SpecularIds { uvec2 specular_ids[]; };
layout(set = 3, binding = 11, std430) readonly buffer Shares { Share shares[]; };
layout(set = 3, binding = 4, std430) readonly buffer PhotonOrder { uint photon_order[]; };
layout(set = 3, binding = 13, std430) readonly buffer BluePoints { uint blue_points[]; }; // of a tile of cells, a place each
layout(push_constant) uniform EmissionPush {
    float ledger_unit; // W
    uint photons;
    uint views;        // of lights
    uint set;
    float rough_alpha; // GGX width of the roughest mirror that is followed
    float faint;       // of a photon of the mean flux: fainter ones are followed by chance
    uint seed;
    uint shuffled;     // 1: slots' photons are as PhotonOrder says
    uint blue_side;    // cells along a side of the tile of BluePoints; 0: places are anywhere in their cells
    uint fates;        // FATES
} push;

uint share_of(uint photon) {
    uint found = 0u;
    for (uint i = 1u; i < push.views; i++) {
        if (photon >= shares[i].first) found = i;
    }
    return found;
}

// The photon's cell in its share's grid: eight by eight a workgroup, in Morton order.
uvec2 cell_of(Share share, uint index) {
    uint tile = index / 64u;
    uint within = index % 64u;
    uint tiles_across = share.columns / 8u;
    uvec2 fine = uvec2((within & 1u) | ((within >> 1) & 2u) | ((within >> 2) & 4u),
                       ((within >> 1) & 1u) | ((within >> 2) & 2u) | ((within >> 3) & 4u));
    return 8u * uvec2(tile % tiles_across, tile / tiles_across) + fine;
}

// Where in its cell a photon of this set starts, cells; with blue points, up to a cell beyond. Their tile lies elsewhere in each
// set, anywhere with equal probability, so that the mean of many sets is even.
vec2 place_in(uvec2 cell, uint photon) {
    if (push.blue_side == 0u) return sample_2d(push.set, combine(combine(push.seed, photon), 1u));
    vec2 shift = float(push.blue_side) * sample_2d(push.set, combine(push.seed, 5u));
    uvec2 at = (cell + uvec2(shift)) % push.blue_side;
    uint point = blue_points[at.y * push.blue_side + at.x];
    return vec2(point & 0xffffu, point >> 16) / 65536.0 + fract(shift);
}

// The specular surface at a place of the view: the triangle of the nearest texel, or of one of its neighbours where that
// has the place inside. False where there is none or something opaque is before it.
bool surface_seen(LightView v, vec2 place, vec3 origin, vec3 direction, out Surface surface, out uvec2 ids) {
    vec2 at = place * vec2(v.columns - 1u, v.rows - 1u);
    uvec2 low = min(uvec2(at), uvec2(v.columns, v.rows) - 2u);
    uvec2 near = low + uvec2(greaterThanEqual(at - vec2(low), vec2(0.5)));
    ids = specular_ids[id_index(v, near)];
    if (ids.x == 0u) return false;
    vec2 barycentrics;
    bool inside = meets(ids.x - 1u, ids.y, origin, direction, barycentrics);
    for (uint i = 0u; i < 4u && !inside; i++) {
        uvec2 other = specular_ids[id_index(v, low + uvec2(i & 1u, i >> 1))];
        if (other.x == 0u || other == ids) continue;
        vec2 found;
        if (meets(other.x - 1u, other.y, origin, direction, found)) {
            inside = true;
            barycentrics = found;
            ids = other;
        }
    }
    if (!inside) {
        // Between the triangles of four texels: the nearest one's plane, within half a texel of it.
        float t = plane_distance(plane_of(v, ids), origin, direction);
        if (!(t > 0.0)) return false;
        barycentrics = barycentrics_of(ids, origin + t * direction);
    }
    surface = surface_at(ids.x - 1u, ids.y, barycentrics);
    uvec2 opaque = opaque_ids[id_index(v, near)];
    if (opaque.x == 0u) return true;
    float t = plane_distance(plane_of(v, opaque), origin, direction);
    return !(t > 0.0 && t < dot(surface.position - origin, direction));
}

// What the light sends through a place of its view. False where nothing goes on.
bool emit(Share share, LightView v, vec2 place, uint photon, out Photon p) {
    vec2 chart = chart_at(v, place);
    Light light = lights[v.light];
    vec3 origin, direction;
    light_ray(v, chart, origin, direction);
    vec2 extent = v.upper - v.lower;
    vec3 flux = light_power(v, light, chart) * (extent.x * extent.y / (float(share.columns) * float(share.rows)));
    p = Photon(origin, direction, flux, light.medium, 0u);
    fate_watts[0] = mean(flux);
    if (mean(flux) <= 0.0) return false;
    Surface s;
    uvec2 ids;
    if (!surface_seen(v, place, origin, direction, s, ids)) {
        ends(LEDGER_MISSED, flux);
        return false;
    }
    vec3 left = flux;
    if (v.perspective == 0u) {
        // It has come through all of the medium that lies before the plane on which the view starts.
        left *= transmittance(light.medium, origin, -direction, FAR_AWAY);
    }
    left *= transmittance(light.medium, origin, direction, length(s.position - origin));
    takes(light.medium, flux - left);
    p.flux = left;

    uint seed = combine(push.seed, photon);
    Material material = materials[s.material];
    bool crosses = false;
    if (material.kind == MATERIAL_DIELECTRIC) {
        Interface i = interface_at(s, direction);
        // One branch by chance: a photon that is reflected is not lost (erratum 13).
        if (sample_1d(push.set, combine(seed, 2u)) < i.reflectance) {
            p.direction = reflected(i, direction);
        } else {
            p.direction = refracted(i, direction);
            p.medium = i.beyond;
            crosses = true;
        }
    } else {
        vec3 weight = material.color;
        if (material.kind == MATERIAL_MIRROR) {
            p.direction = normalize(reflect(direction, dot(direction, s.geometric) < 0.0 ? s.shading : -s.shading));
        } else if (material.alpha > push.rough_alpha) {
            ends(LEDGER_ROUGH, p.flux);
            return false;
        } else if (HAS_ROUGH) {
            p.direction = reflect_rough(s, direction, sample_2d(push.set, combine(seed, 3u)), weight);
        }
        fate_watts[1] += mean(p.flux * (1.0 - weight));
        p.flux *= weight;
        if (mean(p.flux) <= 0.0) return false;
    }
    if (!stays_on_side(s, direction, p.direction, crosses)) {
        ends(LEDGER_WRONG_SIDE, p.flux);
        return false;
    }
    p.origin = leave(s, p.direction);
    if (!all_finite(p.origin) || !all_finite(p.direction) || !all_finite(p.flux)) {
        ends(LEDGER_NON_FINITE, vec3(push.ledger_unit));
        return false;
    }
    return true;
}

// Faint photons are followed by chance, those that are with more flux: nothing is lost in the mean.
bool survives(inout Photon p, Share share, uint photon) {
    float least = push.faint * share.power;
    float own = mean(p.flux);
    if (own >= least) return true;
    if (sample_1d(push.set, combine(combine(push.seed, photon), 4u)) * least >= own) {
        fate_watts[3] = own;
        return false;
    }
    fate_watts[4] = least - own;
    p.flux *= least / own;
    return true;
}

void main() {
    open_tallies();
    barrier();
    uint slot = linear_index();
    if (slot < push.photons) {
        uint photon = push.shuffled != 0u ? photon_order[slot] : slot;
        uint view_index = share_of(photon);
        Share share = shares[view_index];
        uvec2 cell = cell_of(share, photon - share.first);
        // What is beyond the last cell begins anew before the first.
        vec2 place = fract((vec2(cell) + place_in(cell, photon)) / vec2(share.columns, share.rows));
        Photon p;
        bool starts = emit(share, light_views[view_index], place, photon, p) && survives(p, share, photon);
        p.view = view_index;
        if (starts) {
            photon_records[slot] = packed_photon(p);
            count(TALLY_TRACED, 1u);
        } else {
            photon_records[slot] = no_photon();
        }
        book_fates(push.fates, push.ledger_unit);
    }
    close_tallies();
}
