// The refracting surface, triangle by triangle, in the world and in cells.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/scene.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(push_constant) uniform FacetPush {
    uint volume;
    uint instance;
    uint triangles;
    uint parts; // invocations a triangle
} push;

struct Facet {
    vec3 corner[3];
    vec3 cells[3]; // the corners in columns and planes
    vec3 normal;   // unit, counter-clockwise
    vec3 to_light; // the normal on the light's side, in columns and planes
    bool valid;    // false where it is degenerate, or does not part the light's medium from the wave's
};

Facet facet_of(EikonalVolume volume, uint primitive) {
    Facet f;
    triangle_corners(push.instance, primitive, f.corner[0], f.corner[1], f.corner[2]);
    vec3 face = cross(f.corner[1] - f.corner[0], f.corner[2] - f.corner[0]);
    float size = length(face);
    f.normal = face / max(size, 1e-30);
    for (int i = 0; i < 3; i++) f.cells[i] = to_cells(volume.grid, f.corner[i]);
    Instance instance = instances[push.instance];
    Material material = materials[instance.material];
    bool front = material.front == volume.light_medium && material.back == volume.wave_medium;
    bool back = material.back == volume.light_medium && material.front == volume.wave_medium;
    float side = front ? 1.0 : -1.0;
    if (instance.mirrored != 0u) side = -side;
    f.to_light = turn_to_cells(volume.grid, side * f.normal);
    f.valid = size > 0.0 && (front || back) && all_finite(f.corner[0]) && all_finite(f.corner[1]) && all_finite(f.corner[2]);
    return f;
}
