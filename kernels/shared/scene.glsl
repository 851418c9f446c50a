// The scene in buffers. renderer/gpu_scene.rs fills them; structs have the same names and fields there.
#include "shared/vertex.glsl"

struct Instance {
    vec4 to_world[3];  // rows of the affine map from object to world space
    vec4 to_object[3]; // and of its inverse
    uint first_vertex; // into vertices
    uint first_index;  // into indices; three a triangle, relative to first_vertex
    uint triangles;
    uint material;
    uint mask;     // MASK_SPECULAR or MASK_DIFFUSE
    uint mirrored; // 1 where the transform turns the winding round
    uint padding0;
    uint padding1;
};

const uint MATERIAL_DIFFUSE = 0;
const uint MATERIAL_DIELECTRIC = 1;
const uint MATERIAL_MIRROR = 2;
const uint MATERIAL_ROUGH = 3;

struct Material {
    uint kind;
    uint front;   // dielectric: medium on the side of the geometric normal
    uint back;    // dielectric: medium on the other side
    uint texture; // NO_TEXTURE or an index into textures
    vec3 color;   // albedo or reflectance
    float alpha;  // GGX width of a rough mirror
};

struct Medium {
    vec3 absorption; // 1/m
    float index;     // refractive index
    vec3 scattering; // 1/m
    float asymmetry; // Henyey-Greenstein g
    uint grid;       // NO_GRID or an index into density_grids
    uint padding0;
    uint padding1;
    uint padding2;
};

// Density, by which a medium's coefficients are multiplied, at points on the corners of cells; x counts up first.
struct DensityGrid {
    vec3 lower;           // m, where the first point is
    uint first_voxel;     // into voxels
    vec3 cells_per_metre; // along each axis
    uint padding0;
    uvec3 points;         // along each axis, at least 2
    uint padding1;
};

const uint LIGHT_POINT = 0;
const uint LIGHT_SPOT = 1;
const uint LIGHT_DIRECTIONAL = 2;

struct Light {
    vec3 position;
    uint kind;
    vec3 direction; // unit, the way the light travels
    uint medium;
    vec3 intensity; // W/sr; directional: W/m2 on a plane perpendicular to the direction
    float cos_inner;
    float cos_outer;
    uint image;       // NO_TEXTURE, or what a spot light projects: an index into textures
    float half_width; // of the image, one metre from the light
    uint padding0;
    vec3 up;          // unit, across the direction: the image's top
    uint padding1;
};

struct Texture {
    uint first_texel;
    uint width;
    uint height;
    uint padding0;
};

const uint NO_GRID = 0xffffffffu;
const uint NO_TEXTURE = 0xffffffffu;
const uint NO_INSTANCE = 0xffffffffu;
const uint MASK_SPECULAR = 1u;
const uint MASK_DIFFUSE = 2u;
const uint MASK_ALL = 3u;

layout(set = 0, binding = 0, std430) readonly buffer Vertices { Vertex vertices[]; };
layout(set = 0, binding = 1, std430) readonly buffer Indices { uint indices[]; };
layout(set = 0, binding = 2, std430) readonly buffer Instances { Instance instances[]; };
layout(set = 0, binding = 3, std430) readonly buffer Materials { Material materials[]; };
layout(set = 0, binding = 4, std430) readonly buffer Media { Medium media[]; };
layout(set = 0, binding = 5, std430) readonly buffer Lights { Light lights[]; };
layout(set = 0, binding = 6, std430) readonly buffer Textures { Texture textures[]; };
layout(set = 0, binding = 7, std430) readonly buffer Texels { uint texels[]; };

vec3 transform_point(vec4 rows[3], vec3 p) {
    vec4 q = vec4(p, 1.0);
    return vec3(dot(rows[0], q), dot(rows[1], q), dot(rows[2], q));
}

vec3 transform_vector(vec4 rows[3], vec3 v) {
    return vec3(dot(rows[0].xyz, v), dot(rows[1].xyz, v), dot(rows[2].xyz, v));
}

// A normal's way to world space: the transposed inverse.
vec3 transform_normal(vec4 inverse_rows[3], vec3 n) {
    return inverse_rows[0].xyz * n.x + inverse_rows[1].xyz * n.y + inverse_rows[2].xyz * n.z;
}

// Indices into `vertices` of a triangle of an instance.
uvec3 triangle_vertices(Instance instance, uint primitive) {
    uint at = instance.first_index + 3u * primitive;
    return uvec3(indices[at], indices[at + 1u], indices[at + 2u]) + instance.first_vertex;
}

// Its corners, world space.
void triangle_corners(uint instance_id, uint primitive, out vec3 a, out vec3 b, out vec3 c) {
    Instance instance = instances[instance_id];
    uvec3 corner = triangle_vertices(instance, primitive);
    a = transform_point(instance.to_world, vertices[corner.x].position);
    b = transform_point(instance.to_world, vertices[corner.y].position);
    c = transform_point(instance.to_world, vertices[corner.z].position);
}
