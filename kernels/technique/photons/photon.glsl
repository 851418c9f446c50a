// A photon on its way from a specular surface.
#include "shared/math.glsl"

struct Photon {
    vec3 origin;
    vec3 direction;
    vec3 flux;   // W
    uint medium;
    uint view;   // of the light that sent it
};

// As it is kept, a slot each: one that goes nowhere has no flux. Once an image space has found where it lands, but on what
// the camera's view does not show, its medium is NO_MEDIUM, and its place and normal there are kept.
struct PhotonRecord {
    vec3 origin;
    uint direction; // packed
    vec3 flux;
    uint medium_view; // 16 bits each
};

const uint NO_MEDIUM = 0xffffu;

PhotonRecord no_photon() {
    return PhotonRecord(vec3(0.0), 0u, vec3(0.0), 0u);
}

PhotonRecord packed_photon(Photon p) {
    return PhotonRecord(p.origin, pack_direction(p.direction), p.flux, p.medium | (p.view << 16));
}

Photon unpacked_photon(PhotonRecord r) {
    return Photon(r.origin, unpack_direction(r.direction), r.flux, r.medium_view & 0xffffu, r.medium_view >> 16);
}

layout(set = 3, binding = 12, std430) buffer PhotonRecords { PhotonRecord photon_records[]; };
