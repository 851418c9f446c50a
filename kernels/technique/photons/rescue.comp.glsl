// Finishes by a ray the photons that the image spaces lost.
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
    uint fates; // FATES
} push;

// Where a photon lands, or has landed.
struct Landing {
    vec3 position;
    vec3 geometric; // on its side
    vec3 flux;      // W
    vec3 printed;   // W times the cosine, for Eq. 3
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
                      left * max(-dot(direction, shading), 0.0));
    return diffuse;
}

void rescue(Photon p) {
    Landing landing = Landing(p.origin, p.direction, p.flux, p.flux);
    uint texel = NO_TEXEL;
    if (p.medium != NO_MEDIUM) {
        if (!finish(p, landing)) return;
        vec4 at;
        texel = texel_showing(light_views[push.store.camera], push.store.camera, landing.position, 1.0, at);
    }
    if (texel != NO_TEXEL) {
        add_to_texel(texel, push.printed_area != 0u ? landing.printed : landing.flux, push.store.flux_unit);
    } else if (!store_in_cubes(push.store, landing.position, landing.geometric, landing.flux)) {
        count(TALLY_FULL, 1u);
    }
}

void main() {
    open_tallies();
    barrier();
    uint index = linear_index();
    if (index < push.photons) {
        PhotonRecord record = photon_records[index];
        if (mean(record.flux) > 0.0) {
            rescue(unpacked_photon(record));
            book_fates(push.fates, push.ledger_unit);
        }
    }
    close_tallies();
}
