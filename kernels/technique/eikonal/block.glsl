// Visits the planes of one block in a column, each with the planes before it at hand.

// False where the value is given or there is none to be.
bool open_cell(uint known) {
    return (known & GIVEN) == 0u && known != floatBitsToUint(OUTSIDE);
}

// The largest change, in metres times index.
float visit(EikonalSweep sweep, ivec2 column, int block) {
    int plane = block * BLOCK;
    int end = min(plane + BLOCK, int(sweep.cells.z));
    int cell = sweep.first + column.x * sweep.strides.x + column.y * sweep.strides.y + plane * sweep.strides.z;
    vec2 before = vec2(UNKNOWN);
    if (plane > 0) before.x = value_at(cell - sweep.strides.z);
    if (plane > 1) before.y = value_at(cell - 2 * sweep.strides.z);
    float change = 0.0;
    for (; plane < end; plane++) {
        uint known = values[cell];
        float value = abs(uintBitsToFloat(known));
        if (open_cell(known)) {
            ivec3 at = ivec3(column, plane);
            float was = value;
            Updated found = updated(sweep, at, cell, before);
            // Of first order values only fall. Differences of second order do not promise that.
            value = (sweep.options & SWEEP_SECOND) == 0u ? min(found.value, was) : found.value;
            change = max(change, abs(value - was));
            values[cell] = floatBitsToUint(value);
            if (at.x == 0 || at.x == int(sweep.cells.x) - 1) sides[side_u(sweep.cells, at)] = found.rise.x;
            if (at.y == 0 || at.y == int(sweep.cells.y) - 1) sides[side_v(sweep.cells, at)] = found.rise.y;
        }
        before = vec2(value, before.x);
        cell += sweep.strides.z;
    }
    return change;
}
