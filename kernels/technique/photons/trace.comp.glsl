// Follows photons over what the light sees that is opaque and then over what the camera sees, and lands them in the
// camera's texels (Meenrattanakorn and Lambers 2023, section 3.2). One invocation a photon.
#include "technique/photons/march.glsl"
#include "technique/photons/photon.glsl"
#include "technique/photons/store.glsl"
#include "technique/photons/fates.glsl"
#include "technique/photons/tallies.glsl"

layout(push_constant) uniform TracePush {
    StorePush store;
    float ledger_unit; // W
    uint photons;
    uint options;      // bits, below
    uint max_steps;
    uint turns;        // views that a photon is followed over: the light's, and the camera's where no ray rescues
    uint fates;        // FATES
} push;

const uint OPTION_LINEAR_MARCH = 1u;
const uint OPTION_LINEAR_END = 2u;
const uint OPTION_RESCUE = 4u;
const uint OPTION_PRINTED_AREA = 8u; // Eq. 3 as printed: flux times the incident cosine (erratum 12)
const uint OPTION_SPLATS = 16u;      // photons/splat draws them

// Cosine between a photon and what it lands on below which it is counted as grazing.
const float SKIMMING = 0.05;

// Into a texel of the camera's view, after `t` metres; what is left for others to do.
PhotonRecord land(Photon p, vec3 flux, float t, uint texel) {
    ends(LEDGER_LANDED, flux);
    CameraTexel seen = camera_texels[texel];
    vec3 geometric = unpack_direction(seen.geometric);
    if (-dot(p.direction, geometric) < SKIMMING) count(TALLY_SKIMMING, 1u);
    vec3 shading = unpack_direction(seen.shading);
    bool printed = (push.options & OPTION_PRINTED_AREA) != 0u;
    flux *= printed ? max(-dot(p.direction, shading), 0.0) : shading_ratio(p.direction, shading, geometric);
    bool splats = (push.options & OPTION_SPLATS) != 0u;
    if (!splats) add_to_texel(texel, flux, push.store.flux_unit);
    bool kept = splats || (push.options & OPTION_RESCUE) != 0u;
    return kept ? PhotonRecord(p.origin + t * p.direction, texel, flux, LANDED) : no_photon();
}

// Whether a place is behind what the camera's view shows, or outside of it; what floats before that has not landed yet.
bool is_hidden(LightView camera, vec4 at) {
    if (at.w < NEAREST) return true;
    vec2 place = at.xy / at.z;
    if (!inside_view(camera, place)) return true;
    return at.w > depth_slabs[slab_index(camera, push.store.camera, 0u, uvec2(place))].x;
}

// What photons/rescue needs of a photon that landed at a texel of its light's view, on what the camera's does not show.
PhotonRecord hidden_landing(Photon p, vec3 flux, Trail trail) {
    uvec2 ids = opaque_ids[id_index(light_views[p.view], trail.texel)];
    vec3 position = p.origin + trail.t * p.direction;
    Surface s = surface_at(ids.x - 1u, ids.y, barycentrics_of(ids, position));
    // The shading normal of the side that is seen, as the plane's is.
    vec3 shading = dot(s.shading, trail.plane.normal) < 0.0 ? -s.shading : s.shading;
    flux *= shading_ratio(p.direction, shading, trail.plane.normal);
    return PhotonRecord(position, pack_direction(trail.plane.normal), flux, NO_MEDIUM);
}

// Over the light's view, then over the camera's from where that ended, unless a ray does the rest. What is left for others
// to do.
PhotonRecord follow(Photon p) {
    bool rescue = (push.options & OPTION_RESCUE) != 0u;
    MarchSettings how = MarchSettings((push.options & OPTION_LINEAR_MARCH) == 0u, (push.options & OPTION_LINEAR_END) != 0u,
                                      true, push.max_steps);
    LightView camera = light_views[push.store.camera];
    uint texel = NO_TEXEL;
    bool hidden = false;
    Trail trail;
    trail.t = 0.0;
    uint index = p.view;
    // One loop, so that the march is compiled once.
    for (uint turn = 0u; turn < push.turns && texel == NO_TEXEL && !hidden; turn++) {
        bool last = turn == 1u;
        LightView v = light_views[index];
        how.stops_hidden = !last;
        trail = march(v, index, p.origin, p.direction, trail.t, how);
        count(last ? TALLY_CAMERA_STEPS : TALLY_LIGHT_STEPS, trail.steps);
        if (trail.end == TRAIL_LONG) count(TALLY_LONG, 1u);
        index = push.store.camera;
        if (trail.end != TRAIL_HIT) continue;
        count(last ? TALLY_CAMERA_HITS : TALLY_LIGHT_HITS, 1u);
        if (last) {
            texel = trail.texel.y * v.columns + trail.texel.x;
        } else {
            vec4 at;
            uint instance = opaque_ids[id_index(v, trail.texel)].x - 1u;
            Spot spot = Spot(p.origin + trail.t * p.direction, instance, trail.plane.normal);
            texel = texel_for(push.store, camera, spot, false, at);
            hidden = texel == NO_TEXEL && is_hidden(camera, at);
        }
    }
    if (texel == NO_TEXEL && !hidden) {
        if (rescue) return packed_photon(p);
        ends(LEDGER_LOST, p.flux);
        return no_photon();
    }
    vec3 flux = p.flux * transmittance(p.medium, p.origin, p.direction, trail.t);
    takes(p.medium, p.flux - flux);
    if (!hidden) return land(p, flux, trail.t, texel);
    ends(LEDGER_HIDDEN, flux);
    return rescue ? hidden_landing(p, flux, trail) : no_photon();
}

void main() {
    open_tallies();
    barrier();
    uint slot = linear_index();
    if (slot < push.photons) {
        PhotonRecord record = photon_records[slot];
        if (mean(record.flux) > 0.0) {
            photon_records[slot] = follow(unpacked_photon(record));
            book_fates(push.fates, push.ledger_unit);
        }
    }
    close_tallies();
}
