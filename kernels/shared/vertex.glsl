// A mesh vertex; `Vertex` in renderer/gpu_scene.rs.
struct Vertex { // object space
    vec3 position;
    float u;
    vec3 normal; // unit
    float v;
};
