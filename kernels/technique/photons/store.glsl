// Where landed photons go: into the texel of the camera's view that shows the place, and, where none does, into a table
// of cubes in space. Sums are integers, so that they do not depend on the order of photons.
#include "technique/photons/spaces.glsl"
#include "shared/view.glsl"
#include "shared/random.glsl"

// What the camera's view shows at a texel.
struct CameraTexel {
    float depth;    // m along the view; 0: nothing
    uint shading;   // packed, on the side that is seen
    uint geometric;
    uint instance;
};

layout(set = 3, binding = 6, std430) buffer PhotonFlux { uint photon_flux[]; };          // r, g, b by texel
layout(set = 3, binding = 7, std430) buffer CameraTexels { CameraTexel camera_texels[]; };
layout(set = 3, binding = 8, std430) buffer PhotonCubes { uint photon_cubes[]; };        // key, r, g, b by slot

// How light is stored, the same for all kernels of a set.
struct StorePush {
    uint camera;      // index of the camera's view
    uint cubes;       // slots of the table, a power of two; 0: no table
    float cube_pixels; // side of cubes, in pixels at their distance, at the least
    uint seed;        // of the set: cubes lie elsewhere in each
    float flux_unit;  // W
    uint probes;      // slots looked at for a cube; a constant would be unrolled, at seconds to lavapipe's compiler
    uint near;        // texels looked at for a place, 9, for the same reason
};

// Of the shading normal's cosine to the geometric one's: a bound for light that grazes a face.
const float MAX_COSINE_RATIO = 8.0;
const uint EMPTY = 0u;
const uint NO_TEXEL = 0xffffffffu;

bool inside_view(LightView v, vec2 place) {
    return all(greaterThanEqual(place, vec2(0.0))) && all(lessThan(place, vec2(v.columns, v.rows)));
}

// A place on a surface.
struct Spot {
    vec3 position;
    uint instance;
    vec3 geometric; // on the side that is meant
};

// Of a spot: how far from the plane of what a texel shows it may be, in texels' widths, and the least cosine of the normals.
const float OFF_PLANE = 2.0;
const float SAME_SIDE = 0.9;

bool shows(LightView v, uvec2 texel, Spot spot, float width) {
    CameraTexel seen = camera_texels[texel.y * v.columns + texel.x];
    if (seen.instance != spot.instance || dot(unpack_direction(seen.geometric), spot.geometric) < SAME_SIDE) return false;
    vec2 chart = chart_of(v, texel);
    vec3 shown = v.origin + seen.depth * (v.forward + chart.x * v.right + chart.y * v.up);
    return abs(dot(shown - spot.position, spot.geometric)) <= OFF_PLANE * width;
}

// The texel of the camera's view that stands for a spot, or NO_TEXEL: the one that it is in, where that shows its surface,
// else the nearest beside it that does; a texel that an edge runs through shows one side of it. What is behind all that its own
// texel shows has one only if it is known to be `seen`: else light of the strip behind an outline would be added along it.
uint texel_for(StorePush push, LightView v, Spot spot, bool seen, out vec4 at) {
    at = place_of(v, spot.position - v.origin);
    if (at.w < NEAREST) return NO_TEXEL;
    vec2 place = at.xy / at.z;
    bool inside = inside_view(v, place);
    float width = texel_width(v, at.w);
    vec2 slab = inside ? depth_slabs[slab_index(v, push.camera, 0u, uvec2(place))] : vec2(NOTHING);
    if (!seen && (!inside || at.w > slab.y + width)) return NO_TEXEL;
    uint found = NO_TEXEL;
    float nearest = 1e30;
    for (uint i = 0u; i < push.near; i++) {
        vec2 texel = floor(place) + vec2(i % 3u, i / 3u) - 1.0;
        vec2 apart = texel + 0.5 - place;
        if (dot(apart, apart) >= nearest || !inside_view(v, texel) || !shows(v, uvec2(texel), spot, width)) continue;
        nearest = dot(apart, apart);
        found = uint(texel.y) * v.columns + uint(texel.x);
    }
    if (found != NO_TEXEL || !inside || at.w < slab.x - width || at.w > slab.y + width) return found;
    // On a surface bent more than texels tell: what lies about as deep and on the same side.
    uint own = uint(place.y) * v.columns + uint(place.x);
    return dot(unpack_direction(camera_texels[own].geometric), spot.geometric) > 0.5 ? own : NO_TEXEL;
}

uvec3 units_of(vec3 flux, float unit) {
    return uvec3(clamp(flux / unit + 0.5, vec3(0.0), vec3(4.0e9)));
}

void add_to_texel(uint texel, vec3 flux, float unit) {
    uvec3 units = units_of(flux, unit);
    for (uint c = 0u; c < 3u; c++) {
        if (units[c] > 0u) atomicAdd(photon_flux[3u * texel + c], units[c]);
    }
}

// Over the geometric cosine, which flux per area carries, the shading normal's: irradiance, like direct light's, goes by it.
float shading_ratio(vec3 direction, vec3 shading, vec3 geometric) {
    float ratio = dot(direction, shading) / dot(direction, geometric);
    return ratio == ratio ? clamp(ratio, 0.0, MAX_COSINE_RATIO) : 1.0;
}

// Logarithm of the side of cubes at a distance.
int cube_level(StorePush push, float distance) {
    return int(ceil(log2(max(push.cube_pixels * view.pixel_angle * distance, 1e-9))));
}

float cube_side(int level) {
    return exp2(float(level));
}

// Where cubes begin in this set, in sides.
vec3 cube_shift(StorePush push, int level) {
    uint seed = combine(push.seed, uint(level));
    return vec3(to_unit(combine(seed, 1u)), to_unit(combine(seed, 2u)), to_unit(combine(seed, 3u)));
}

ivec3 cube_of(StorePush push, vec3 position, int level, out vec3 inside) {
    vec3 at = position / cube_side(level) + cube_shift(push, level);
    vec3 low = floor(at);
    inside = at - low;
    return ivec3(clamp(low, vec3(-1e9), vec3(1e9)));
}

// Of six sides, the one that a normal points to most: both sides of a thin wall are apart.
uint side_of(vec3 normal) {
    vec3 a = abs(normal);
    uint axis = a.x >= a.y && a.x >= a.z ? 0u : a.y >= a.z ? 1u : 2u;
    return 2u * axis + (normal[axis] < 0.0 ? 1u : 0u);
}

// What tells cubes apart, and where the search for one begins.
uvec2 cube_key(ivec3 cube, int level, uint side) {
    uint h = combine(combine(uint(cube.x), uint(cube.y)), uint(cube.z));
    h = combine(h, uint(level + 64) * 8u + side);
    return uvec2(max(mix_bits(h ^ 0x68bc21ebu), 1u), h);
}

// False where the table has no room.
bool add_to_cube(StorePush push, uvec2 key, uvec3 units) {
    for (uint i = 0u; i < push.probes; i++) {
        uint slot = 4u * ((key.y + i) & (push.cubes - 1u));
        uint found = atomicCompSwap(photon_cubes[slot], EMPTY, key.x);
        if (found != EMPTY && found != key.x) continue;
        for (uint c = 0u; c < 3u; c++) {
            if (units[c] > 0u) atomicAdd(photon_cubes[slot + 1u + c], units[c]);
        }
        return true;
    }
    return false;
}

// Into the cubes in which points near this one look: two where sides change with the distance. False: no room.
bool store_in_cubes(StorePush push, vec3 position, vec3 normal, vec3 flux) {
    float distance = length(position - view.position);
    int level = cube_level(push, distance);
    float reach = 2.0 * cube_side(level); // more than a cube's diagonal
    int least = cube_level(push, max(distance - reach, 0.5 * distance));
    int most = cube_level(push, distance + reach);
    bool stored = true;
    for (int l = least; l <= min(most, least + 2); l++) {
        vec3 inside;
        ivec3 cube = cube_of(push, position, l, inside);
        stored = add_to_cube(push, cube_key(cube, l, side_of(normal)), units_of(flux, push.flux_unit)) && stored;
    }
    return stored;
}
