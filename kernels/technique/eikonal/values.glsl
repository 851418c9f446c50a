// Values with their marks. The kernel that includes this declares the buffer `values` of their bits.

float value_at(int cell) {
    return abs(uintBitsToFloat(values[cell]));
}

bool given(int cell) {
    return (values[cell] & GIVEN) != 0u;
}

// To be found: neither given nor outside of the medium.
bool open_cell(uint known) {
    return (known & GIVEN) == 0u && known != floatBitsToUint(OUTSIDE);
}
