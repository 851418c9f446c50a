// A triangle of the lattice that is not split.
struct BeamLeaf {
    uvec3 vertices;
    uint cell;   // of the coarse grid, over all views
    vec3 power;  // W through it, before the leaves of a cell are made to add up to the cell's
    uint padding0;
};

layout(set = 3, binding = 8, std430) buffer BeamLeaves { BeamLeaf beam_leaves[]; };
// By vertex, eight each: one more than the leaf in the wedge that begins in that eighth of a turn, 0 for none.
layout(set = 3, binding = 9, std430) buffer VertexFans { uint vertex_fans[]; };
// By coarse cell: what its leaves' powers are multiplied by.
layout(set = 3, binding = 10, std430) buffer CellScales { vec4 cell_scales[]; };
// By coarse cell: its first leaf; one more at the end.
layout(set = 3, binding = 11, std430) buffer CellLeaves { uint cell_leaves[]; };

// Leaves outside of a cone, or drawn in to the border of their view, are not.
bool is_lit(BeamLeaf leaf) {
    return any(greaterThan(leaf.power, vec3(0.0)));
}

vec3 leaf_flux(BeamLeaf leaf) {
    return leaf.power * cell_scales[leaf.cell].rgb;
}
