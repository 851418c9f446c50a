// Stochastic progressive photon mapping (Hachisuka and Jensen 2009): shared by the reference's kernels.
#include "shared/index.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/scene.glsl"
#include "shared/math.glsl"

struct Photon {
    vec3 position;
    uint normal;   // packed, on the side the photon came from; in a volume: the way that it goes
    vec3 flux;     // W; in a volume: what of it is scattered there
    uint landed;   // 0 where the slot holds no photon, else 1; in a volume: 1 + medium
};

// What a pixel layer has gathered so far.
struct Statistic {
    vec3 irradiance_flux; // W within the radius, of all passes
    float radius2;        // m2; 0 before the first visible point
    vec3 radiance_flux;   // as irradiance_flux, each pass weighted by throughput * albedo / pi
    float photons;        // N of the paper: gathered, times alpha for each pass
};

// Of photons on surfaces, cells are one to two to the largest radius in use: finer cells cost more look-ups, coarser ones more photons looked at
// in vain where pixels are small. A gathering sphere touches five of them along an axis, and rounding may add one.
const uint CELLS_PER_AXIS = 6u;

struct GridState {
    uint max_radius; // what cells go by, as the bits of a float in m (positive floats order as their bits do)
};

layout(set = 3, binding = 0, std430) buffer PhotonGrid { GridState grid; };

// A power of two, half the largest radius rounded up: dividing by it is exact, so that every kernel finds a photon in the
// same cell whatever its compiler makes of the division.
float cell_size() {
    uint half_radius = floatBitsToUint(max(0.5 * uintBitsToFloat(grid.max_radius), 1e-9));
    return uintBitsToFloat((half_radius + 0x007fffffu) & 0x7f800000u);
}

ivec3 cell_of(vec3 position, float size) {
    // Far outside the representable range photons share border cells, here as in the search.
    return ivec3(clamp(floor(position / size), vec3(-1e9), vec3(1e9)));
}

// Buckets are a power of two.
uint bucket_of(ivec3 cell, uint buckets) {
    uint h = uint(cell.x) * 0x8da6b343u ^ uint(cell.y) * 0xd8163841u ^ uint(cell.z) * 0xcb1ab31fu;
    h ^= h >> 15;
    h *= 0x2c1b3c6du;
    h ^= h >> 13;
    return h & (buckets - 1u);
}
