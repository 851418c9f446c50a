struct BinaryNode { // object space
    vec3 low;
    uint triangles; // 0 for an inner node
    vec3 high;
    uint first; // child, the other behind it; or triangle
};
