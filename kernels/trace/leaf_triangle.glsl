struct LeafTriangle { // object space
    vec3 a;
    uint primitive; // of the mesh
    vec3 b;
    uint padding0;
    vec3 c;
    uint padding1;
};
