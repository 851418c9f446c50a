// Which blocks of planes in which columns a turn of a sweep visits. None of them is a neighbour of another.

struct EikonalSweep {
    uvec3 cells;   // along u, v and the way of planes
    int first;     // index of cell (0, 0, 0) of columns and planes
    ivec3 strides; // from one cell to the next
    float step;    // refractive index times m
    ivec2 foot;    // the column under the light
    uint turn;
    uint options;  // SWEEP_...
};

const uint SWEEP_SECOND = 1u;     // differences of second order
const uint SWEEP_LINEAR = 2u;     // waves that come in by the grid's sides are as the surface there says
const uint SWEEP_BACKWARD_U = 4u; // of a sweep one way across
const uint SWEEP_BACKWARD_V = 8u;

// Planes that an invocation goes through at once.
const int BLOCK = 4;

// Which column of a row-by-row list `columns` wide. Integers are divided lane by lane on llvmpipe; with fewer than 2048 in a
// row floats are exact.
ivec2 column_of(uint index, uint columns) {
    int row = int((float(index) + 0.5) / float(columns));
    return ivec2(int(index) - row * int(columns), row);
}

// Outward from the foot, on its lower side a turn later, so that the places one below and one above it, which look at each
// other, take turns too. A block and a column along u say how far off the foot along v, on either side of it.
bool outward_block(EikonalSweep sweep, uint index, out ivec2 column, out int block) {
    ivec2 place = column_of(index, 2u * sweep.cells.x);
    block = place.y;
    bool lower = place.x >= int(sweep.cells.x);
    column.x = lower ? place.x - int(sweep.cells.x) : place.x;
    int off_u = column.x - sweep.foot.x;
    int off = int(sweep.turn) - block - (off_u >= 0 ? off_u : 1 - off_u);
    column.y = sweep.foot.y + (lower ? 1 - off : off);
    bool there = off >= (lower ? 2 : 0) && column.y >= 0 && column.y < int(sweep.cells.y);
    return there && block * BLOCK < int(sweep.cells.z);
}

// One way across along each axis.
bool one_way_block(EikonalSweep sweep, uint index, out ivec2 column, out int block) {
    ivec2 place = column_of(index, sweep.cells.x);
    ivec2 last = ivec2(sweep.cells.xy) - 1;
    block = place.y;
    column = ivec2(place.x, int(sweep.turn) - block - place.x);
    bool there = column.y >= 0 && column.y <= last.y && block * BLOCK < int(sweep.cells.z);
    if ((sweep.options & SWEEP_BACKWARD_U) != 0u) column.x = last.x - column.x;
    if ((sweep.options & SWEEP_BACKWARD_V) != 0u) column.y = last.y - column.y;
    return there;
}

int asked_index(EikonalSweep sweep, ivec2 column, int block) {
    return (block * int(sweep.cells.y) + column.y) * int(sweep.cells.x) + column.x;
}
