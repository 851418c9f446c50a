// The leaf triangles of the lattice, by nodes of one quadtree a coarse cell: a node is a cell whose middle is a vertex, and
// has up to eight triangles round that vertex. The first node of each coarse cell stands for the cell as it is where it is
// not split.
#include "technique/beams/lattice.glsl"

// 1 + (1 + 4 + ... ) over the levels that have middles.
uint nodes_per_cell() {
    return 1u + ((1u << (2u * settings.levels)) - 1u) / 3u;
}

// Where a leaf can be: eight places a node.
uint leaf_places() {
    return 8u * settings.views * settings.grid * settings.grid * nodes_per_cell();
}

uint cell_of_place(uint place) {
    return place / 8u / nodes_per_cell();
}

// Every other bit, put together.
uint even_bits(uint x) {
    x &= 0x55555555u;
    x = (x | (x >> 1)) & 0x33333333u;
    x = (x | (x >> 2)) & 0x0f0f0f0fu;
    x = (x | (x >> 4)) & 0x00ff00ffu;
    return (x | (x >> 8)) & 0x0000ffffu;
}

// Whether there is a leaf in that place, and its corners on the lattice, counter-clockwise in the chart.
bool leaf_at(uint place, out uint view, out ivec2 a, out ivec2 b, out ivec2 c) {
    uint node = place / 8u;
    uint edge = place / 2u % 4u;
    bool second = (place & 1u) != 0u;
    uint cell = node / nodes_per_cell();
    uint rest = node % nodes_per_cell();
    view = cell / (settings.grid * settings.grid);
    uint in_view = cell % (settings.grid * settings.grid);
    ivec2 low = ivec2(in_view % settings.grid, in_view / settings.grid) << int(settings.levels);
    int side = int(1u << settings.levels);
    if (rest == 0u) {
        a = low;
        b = second ? low + side : low + ivec2(side, 0);
        c = second ? low + ivec2(0, side) : low + side;
        return edge == 0u && (settings.levels == 0u || vertex_at(view, low + side / 2) == NO_VERTEX);
    }
    rest -= 1u;
    uint level = 0u;
    while (level + 1u < settings.levels && rest >= (1u << (2u * level))) {
        rest -= 1u << (2u * level);
        level++;
    }
    side >>= int(level);
    low += ivec2(even_bits(rest), even_bits(rest >> 1)) * side;
    c = low + side / 2;
    // Counter-clockwise round the cell.
    a = low + side * ivec2(edge == 1u || edge == 2u, edge >= 2u);
    b = low + side * ivec2(edge <= 1u, edge == 1u || edge == 2u);
    if (vertex_at(view, c) == NO_VERTEX) return false;
    ivec2 between = (a + b) / 2;
    if (vertex_at(view, between) == NO_VERTEX) return !second;
    // The halves are split where the cells of the next level have middles.
    ivec2 corner = second ? b : a;
    if (side > 2 && vertex_at(view, (corner + c) / 2) != NO_VERTEX) return false;
    if (second) {
        a = between;
    } else {
        b = between;
    }
    return true;
}
