struct WideNode { // object space
    vec3 origin; // of the grid that the children's boxes are on
    uint scales; // biased exponents of the grid's step along x, y, z; then a bit for each child that is a node
    uint first_node; // children that are nodes, in the order of their slots
    uint first_triangle;
    uvec2 meta; // a byte a slot: 0 if empty; node: 32 + 24 + slot; leaf: unary count << 5 | offset of its triangles
    uvec4 x; // a byte a slot: low planes in the first two words, high planes in the others
    uvec4 y;
    uvec4 z;
};
