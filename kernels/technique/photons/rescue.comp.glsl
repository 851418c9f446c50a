// Finishes by a ray the photons that the image spaces lost, and keeps all that landed in space.
#include "technique/photons/store.glsl"
#include "technique/photons/fates.glsl"
#include "technique/photons/tallies.glsl"
#include "technique/photons/photon.glsl"
#include "trace/interface.glsl"

layout(push_constant) uniform RescuePush {
    StorePush store;
    float ledger_unit; // W
    uint photons;
    uint printed_area;
    uint splats; // 1: photons/splat draws what lands in texels
    uint fates;  // FATES
} push;

// Where a photon lands, or has landed.
struct Landing {
    vec3 position;
    vec3 geometric; // on its side
    vec3 flux;      // W
    vec3 printed;   // W times the cosine, for Eq. 3
    uint instance;
};

// False where it lands nowhere.
bool finish(Photon p, out Landing landing) {
    vec3 direction = p.direction;
    Hit hit = trace_closest(Ray(p.origin, 0.0, direction, 1e30), MASK_ALL);
    if (hit.instance == NO_INSTANCE) {
        ends(LEDGER_ESCAPED, p.flux);
        return false;
    }
    Surface s = surface_at(hit.instance, hit.primitive, hit.barycentrics);
    vec3 left = p.flux * transmittance(p.medium, p.origin, direction, length(s.position - p.origin));
    takes(p.medium, p.flux - left);
    bool diffuse = materials[s.material].kind == MATERIAL_DIFFUSE;
    ends(diffuse ? LEDGER_RESCUED : LEDGER_SPECULAR, left);
    bool front = dot(direction, s.geometric) < 0.0;
    vec3 geometric = front ? s.geometric : -s.geometric;
    vec3 shading = front ? s.shading : -s.shading;
    landing = Landing(s.position, geometric, left * shading_ratio(direction, shading, geometric),
                      left * max(-dot(direction, shading), 0.0), hit.instance);
    return diffuse;
}

// What is left of it for photons/splat.
PhotonRecord rescue(PhotonRecord record) {
    Landing landing = Landing(record.origin, vec3(0.0), record.flux, record.flux, NO_INSTANCE);
    PhotonRecord left = no_photon();
    if (medium_of(record) == LANDED) {
        landing.geometric = unpack_direction(camera_texels[record.direction].geometric);
        left = record;
    } else if (medium_of(record) == NO_MEDIUM) {
        landing.geometric = unpack_direction(record.direction);
    } else {
        if (!finish(unpacked_photon(record), landing)) return left;
        vec4 at;
        Spot spot = Spot(landing.position, landing.instance, landing.geometric);
        uint texel = texel_for(push.store, light_views[push.store.camera], spot, false, at);
        vec3 flux = push.printed_area != 0u ? landing.printed : landing.flux;
        if (texel != NO_TEXEL && push.splats == 0u) add_to_texel(texel, flux, push.store.flux_unit);
        if (texel != NO_TEXEL) left = PhotonRecord(landing.position, texel, flux, LANDED);
    }
    // What a texel holds too: a cube that has only part of its light would be too dark.
    if (!store_in_cubes(push.store, landing.position, landing.geometric, landing.flux)) count(TALLY_FULL, 1u);
    return left;
}

void main() {
    open_tallies();
    barrier();
    uint index = linear_index();
    if (index < push.photons) {
        PhotonRecord record = photon_records[index];
        if (mean(record.flux) > 0.0) {
            photon_records[index] = rescue(record);
            book_fates(push.fates, push.ledger_unit);
        }
    }
    close_tallies();
}
