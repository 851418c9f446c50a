// Values of cells next to the surface: the shortest optical path from the light through any triangle near by, at the cell's
// own middle (errata 15 and 17). Positive floats sort as integers, so that the least does not depend on the order.
#include "technique/eikonal/surface.glsl"
#include "technique/eikonal/near.glsl"

bool wanted(int cell) {
    float known = uintBitsToFloat(values[cell]);
    return known != OUTSIDE && known != UNKNOWN;
}

void meet(EikonalVolume volume, Facet f, int cell, vec3 to, float bound) {
    if (bound > uintBitsToFloat(values[cell])) return;
    EikonalPath path = path_through(volume.source, f.corner[0], f.corner[1], f.corner[2], f.normal, to, volume.grid.index);
    // Where the surface lies nearer to the light, more of the way is below it; where light crosses it makes no difference to
    // the first order.
    vec3 way = way_at(volume.source, path.at);
    float straight = -dot(way, f.lit);
    float index = volume.grid.index;
    float ahead = sqrt(max(index * index - dot(way, way) + straight * straight, 0.0));
    float value = path.value + bulge_at(f, path.at) * (ahead - straight);
    if (volume.source.kind == SOURCE_SURFACE) value = max(value, 0.0);
    if (value >= 0.0 && value < UNKNOWN) atomicMin(values[cell], floatBitsToUint(value));
}
