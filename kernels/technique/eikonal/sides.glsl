// What is kept of the grid's four sides across the planes: of u = 0 and the last, line after line along v, a line a plane;
// then of v likewise.
uint side_u(uvec3 cells, ivec3 at) {
    uint first = at.x == 0 ? 0u : cells.y * cells.z;
    return first + uint(at.z) * cells.y + uint(at.y);
}

uint side_v(uvec3 cells, ivec3 at) {
    uint first = (at.y == 0 ? 2u * cells.y : 2u * cells.y + cells.x) * cells.z;
    return first + uint(at.z) * cells.x + uint(at.x);
}
