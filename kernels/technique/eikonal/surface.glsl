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
    vec3 lit;      // the same in the world
    vec3 smooth_normal[3]; // shading normals of the corners on that side, unit
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
    f.lit = side * f.normal;
    f.to_light = turn_to_cells(volume.grid, f.lit);
    uvec3 corners = triangle_vertices(instance, primitive);
    for (int i = 0; i < 3; i++) {
        vec3 turned = transform_normal(instance.to_object, vertices[corners[i]].normal);
        float size_of = length(turned);
        turned = size_of > 1e-12 ? turned / size_of : f.lit;
        f.smooth_normal[i] = dot(turned, f.lit) < 0.0 ? -turned : turned;
    }
    f.valid = size > 0.0 && (front || back) && all_finite(f.corner[0]) && all_finite(f.corner[1]) && all_finite(f.corner[2]);
    return f;
}

// How far the surface that the shading normals speak of lies off the triangle at a place on it, m towards the light: half of
// what the corners' tangent planes do in the mean, which is exact for small parts of a sphere. So that light under a mesh does
// not come apart into that of its facets.
float bulge_at(Facet f, vec3 at) {
    vec3 area = vec3(dot(cross(f.corner[2] - f.corner[1], at - f.corner[1]), f.normal),
                     dot(cross(f.corner[0] - f.corner[2], at - f.corner[2]), f.normal),
                     dot(cross(f.corner[1] - f.corner[0], at - f.corner[0]), f.normal));
    area = max(area, vec3(0.0));
    vec3 above = vec3(dot(f.corner[0] - at, f.smooth_normal[0]), dot(f.corner[1] - at, f.smooth_normal[1]),
                      dot(f.corner[2] - at, f.smooth_normal[2]));
    return 0.5 * dot(area, above) / max(area.x + area.y + area.z, 1e-30);
}

// The most that bulge_at can be anywhere on the triangle.
float most_bulge(Facet f) {
    float most = 0.0;
    for (int i = 0; i < 3; i++) {
        vec3 n = f.smooth_normal[i];
        for (int j = 0; j < 3; j++) most = max(most, abs(dot(f.corner[i] - f.corner[j], n)));
    }
    return 0.5 * most;
}
