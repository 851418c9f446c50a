// Whether a cell is so near the surface that its value is given: a place outside of the medium is at most `band` cells away
// along an axis.
bool in_band(EikonalVolume volume, ivec3 at) {
    for (int axis = 0; axis < 3; axis++) {
        for (int way = -int(volume.band); way <= int(volume.band); way++) {
            ivec3 there = at;
            there[axis] += way;
            if (in_grid(volume.grid, there) && values[cell_index(volume.grid, there)] == floatBitsToUint(OUTSIDE)) return true;
        }
    }
    return false;
}
