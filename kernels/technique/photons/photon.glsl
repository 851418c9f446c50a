// A photon on its way from a specular surface.
#include "shared/math.glsl"

struct Photon {
    vec3 origin;
    vec3 direction;
    vec3 flux;   // W
    uint medium;
    uint view;   // of the light that sent it
};

// As it is kept, a slot each: one that goes nowhere has no flux. Where an image space has found
// where it lands, its origin is that place, and its medium says more.
struct PhotonRecord {
    vec3 origin;
    uint direction; // packed
    vec3 flux;
    uint medium_view; // 16 bits each
};

const uint NO_MEDIUM = 0xffffu; // on what the camera's view does not show; direction: the normal there
const uint LANDED = 0xfffeu;    // direction: the texel of the camera's view

PhotonRecord no_photon() {
    return PhotonRecord(vec3(0.0), 0u, vec3(0.0), 0u);
}

PhotonRecord packed_photon(Photon p) {
    return PhotonRecord(p.origin, pack_direction(p.direction), p.flux, p.medium | (p.view << 16));
}

uint medium_of(PhotonRecord r) {
    return r.medium_view & 0xffffu;
}

Photon unpacked_photon(PhotonRecord r) {
    return Photon(r.origin, unpack_direction(r.direction), r.flux, medium_of(r), r.medium_view >> 16);
}

layout(set = 3, binding = 12, std430) buffer PhotonRecords { PhotonRecord photon_records[]; };
