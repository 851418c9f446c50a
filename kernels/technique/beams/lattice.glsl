// Where the vertices of a right-triangulated lattice stand: each but those of the coarse grid is the middle of an edge that
// two triangles share, and splits both, so that there are no T-junctions (Lindstrom et al. 1996, Real-Time, Continuous
// Level of Detail Rendering of Height Fields).
#include "technique/beams/common.glsl"

// A vertex that is not of the coarse grid.
struct Middle {
    uint view;
    ivec2 at;
    int half_side; // of its cell, in columns; 0: a vertex of the coarse grid
    bool of_cell;  // of an edge otherwise
    bool upright;  // of an edge along the rows' axis
};

// Which kind the vertex there is.
Middle middle_at(uint view, ivec2 at) {
    int both = at.x | at.y;
    int half_side = both & -both;
    if (both == 0 || half_side >= int(1u << settings.levels)) half_side = 0;
    bool odd_column = (at.x & half_side) != 0;
    bool odd_row = (at.y & half_side) != 0;
    return Middle(view, at, half_side, odd_column && odd_row, !odd_column);
}

// The ends of the edge that it is the middle of.
void edge_ends(Middle m, out ivec2 first, out ivec2 second) {
    if (!m.of_cell) {
        ivec2 step = m.upright ? ivec2(0, m.half_side) : ivec2(m.half_side, 0);
        first = m.at - step;
        second = m.at + step;
        return;
    }
    // From the corner that the parent cell shares to the parent's middle: the corners whose columns and rows are both, or
    // neither, on the parent's grid. A coarse cell has no parent, and either diagonal will do.
    ivec2 low = m.at - m.half_side;
    int parent = 4 * m.half_side;
    bool coarse = 2 * m.half_side == int(1u << settings.levels);
    bool rising = coarse || (low.x % parent == 0) == (low.y % parent == 0);
    first = rising ? low : low + ivec2(2 * m.half_side, 0);
    second = rising ? low + 2 * m.half_side : low + ivec2(0, 2 * m.half_side);
}

// The corners opposite to that edge in the two triangles on it; off the lattice beyond its border.
void edge_apexes(Middle m, out ivec2 first, out ivec2 second) {
    if (!m.of_cell) {
        ivec2 step = m.upright ? ivec2(m.half_side, 0) : ivec2(0, m.half_side);
        first = m.at - step;
        second = m.at + step;
        return;
    }
    ivec2 from, to;
    edge_ends(m, from, to);
    first = ivec2(from.x, to.y);
    second = ivec2(to.x, from.y);
}
