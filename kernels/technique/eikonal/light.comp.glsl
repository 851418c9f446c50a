// Light just below the surface, across its own way, in cells whose values are given: what the light sends to where the cell's
// path crosses, Fresnel's part of it, by Snell's law over a wider or narrower front, and spread on the way to the cell as the
// wave is curved there.
#include "technique/eikonal/surface.glsl"
#include "technique/eikonal/near.glsl"
#include "shared/optics.glsl"

layout(set = 3, binding = 6, std430) buffer EikonalLights { uint light_bits[]; };

// Of a path, what another facet's may be longer and still be the cell's.
const float SAME = 2e-6;

float value_at(int cell) {
    return abs(uintBitsToFloat(values[cell]));
}

// The wave's Laplacian at a cell, or as near to it as all neighbours are there: a column inwards from the grid's sides, in the
// plane behind where the surface cuts neighbours off. 0 where that is not near enough.
float laplacian(EikonalGrid grid, int cell, ivec3 at) {
    ivec3 inner = clamp(at, ivec3(1), ivec3(grid.cells) - 2);
    if (any(lessThan(ivec3(grid.cells), ivec3(3)))) return 0.0;
    ivec3 step = inner - at;
    cell += step.x * grid.strides.x + step.y * grid.strides.y + step.z * grid.strides.z;
    for (int i = 0; i < 2 && inner.z + i < int(grid.cells.z) - 1; i++) {
        int here = cell + i * grid.strides.z;
        float sum = value_at(here - grid.strides.x) + value_at(here + grid.strides.x) + value_at(here - grid.strides.y) +
                    value_at(here + grid.strides.y) + value_at(here - grid.strides.z) + value_at(here + grid.strides.z);
        if (sum < UNKNOWN) return (sum - 6.0 * value_at(here)) / (grid.cell * grid.cell);
    }
    return 0.0;
}

// Irradiance over the power of the light along its way: 1/m2 of a point light, a number of a directional one.
float light_below(EikonalVolume volume, Facet f, vec3 at, vec3 to) {
    if (volume.source.kind == SOURCE_SURFACE) return 1.0;
    vec3 way = way_at(volume.source, at) / volume.source.index;
    float cos_in = abs(dot(way, f.normal));
    float eta = volume.source.index / volume.grid.index;
    float cos_out = sqrt(max(1.0 - eta * eta * (1.0 - cos_in * cos_in), 1e-4));
    vec3 from = at - volume.source.place;
    float spread = volume.source.kind == SOURCE_POINT ? 1.0 / max(dot(from, from), 1e-12) : 1.0;
    return spread * (1.0 - fresnel(cos_in, eta)) * cos_in / cos_out;
}

bool wanted(int cell) {
    return (values[cell] & GIVEN) != 0u;
}

void meet(EikonalVolume volume, Facet f, int cell, vec3 to, float bound) {
    float known = value_at(cell);
    if (bound > known) return;
    EikonalPath path = path_through(volume.source, f.corner[0], f.corner[1], f.corner[2], f.normal, to, volume.grid.index);
    if (!(path.value <= known + SAME * (known + volume.grid.cell))) return;
    EikonalGrid grid = volume.grid;
    ivec3 place = ivec3(round(to_cells(grid, to)));
    float curved = laplacian(grid, cell, place) * length(to - path.at) / grid.index;
    float light = light_below(volume, f, path.at, to) * exp(-clamp(curved, -1.0, 1.0));
    if (light >= 0.0 && light < UNKNOWN) atomicMax(light_bits[cell], floatBitsToUint(light));
}
