// Visits the planes of one block in a column, each with the planes before it at hand.

// The largest change, in metres times index.
float visit(EikonalSweep sweep, ivec2 column, int block) {
    BlockWalk walk = walk_block(sweep, column, block);
    float change = 0.0;
    while (walk.plane < walk.end) {
        uint known = values[walk.cell];
        float value = abs(uintBitsToFloat(known));
        if (open_cell(known)) {
            ivec3 at = ivec3(column, walk.plane);
            float was = value;
            Updated found = updated(sweep, at, walk.cell, walk.before);
            // Of first order values only fall. Differences of second order do not promise that.
            value = (sweep.options & SWEEP_SECOND) == 0u ? min(found.value, was) : found.value;
            change = max(change, abs(value - was));
            values[walk.cell] = floatBitsToUint(value);
            if (at.x == 0 || at.x == int(sweep.cells.x) - 1) sides[side_u(sweep.cells, at)] = found.rise.x;
            if (at.y == 0 || at.y == int(sweep.cells.y) - 1) sides[side_v(sweep.cells, at)] = found.rise.y;
        }
        step_on(sweep, walk, value);
    }
    return change;
}
