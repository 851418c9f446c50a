// Has a block's neighbours visited again. The kernel that includes this declares the buffer `asked`.
void ask_around(EikonalSweep sweep, ivec2 column, int block, int here) {
    ivec2 last = ivec2(sweep.cells.xy) - 1;
    if (column.x > 0) asked[here - 1] = 1u;
    if (column.x < last.x) asked[here + 1] = 1u;
    if (column.y > 0) asked[here - int(sweep.cells.x)] = 1u;
    if (column.y < last.y) asked[here + int(sweep.cells.x)] = 1u;
    if ((block + 1) * BLOCK < int(sweep.cells.z)) asked[here + int(sweep.cells.x * sweep.cells.y)] = 1u;
}
