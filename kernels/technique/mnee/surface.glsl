// Refracting surfaces as the walk needs them: corners in world space, and what lies across each edge.

struct SpecularVertex { // world space
    vec3 position;
    uint padding0;
    vec3 normal; // as the transform leaves it: normalised only after interpolation, as everywhere
    uint padding1;
};

struct SpecularTriangle {
    uvec3 corner;  // into specular_vertices
    uint instance;
    uvec3 across;  // over the edges 01, 12, 20: four times the triangle there plus its edge, or NO_TRIANGLE
    uint padding0;
};

struct SpecularInstance {
    vec3 axis;           // of a cone that holds all the shading normals
    float cos_spread;    // cosine of the cone's half angle
    uint first_triangle; // into specular_triangles; NO_TRIANGLE where light is not refracted
    uint first_vertex;   // into specular_vertices
    uint padding0;
    uint padding1;
};

const uint NO_TRIANGLE = 0xffffffffu;

layout(set = 3, binding = 0, std430) buffer SpecularVertices { SpecularVertex specular_vertices[]; };
layout(set = 3, binding = 1, std430) readonly buffer SpecularTriangles { SpecularTriangle specular_triangles[]; };
layout(set = 3, binding = 2, std430) readonly buffer SpecularInstances { SpecularInstance specular_instances[]; };
