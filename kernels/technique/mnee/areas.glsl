// Points spread evenly over the area of the surfaces that can refract light from one medium into another.
#include "shared/random.glsl"
#include "technique/mnee/facet.glsl"

// The refracting triangles of an instance.
struct StartSurface {
    uint first_triangle; // into specular_triangles and start_areas
    uint triangles;
    uint front;          // media
    uint back;
    float area;          // m2
    uint padding0;
    uint padding1;
    uint padding2;
};

layout(set = 3, binding = 14, std430) readonly buffer StartSurfaces { StartSurface start_surfaces[]; };
// Up to and with each triangle, in parts of 2^32 of its instance's area.
layout(set = 3, binding = 15, std430) readonly buffer StartAreas { uint start_areas[]; };

bool may_serve(StartSurface surface, uint point_medium, uint light_medium) {
    return (surface.front == point_medium && surface.back == light_medium) ||
           (surface.back == point_medium && surface.front == light_medium);
}

// A point relative to P; false where no surface can serve. Areas are those of the scene as it was loaded: what moves
// changes how likely a start is, and no estimate rests on that.
bool sample_area(Query query, uint surfaces, uint point_medium, uint light_medium, uint seed, out vec3 at) {
    at = vec3(0.0);
    float total = 0.0;
    for (uint i = 0u; i < surfaces; i++) {
        if (may_serve(start_surfaces[i], point_medium, light_medium)) total += start_surfaces[i].area;
    }
    float left = total * to_unit(combine(seed, 1u));
    uint pick = NO_INSTANCE;
    for (uint i = 0u; i < surfaces; i++) {
        if (!may_serve(start_surfaces[i], point_medium, light_medium)) continue;
        pick = i;
        left -= start_surfaces[i].area;
        if (left < 0.0) break;
    }
    if (pick == NO_INSTANCE) return false;
    StartSurface surface = start_surfaces[pick];
    uint wanted = combine(seed, 2u);
    uint low = 0u;
    uint high = surface.triangles - 1u;
    for (uint i = 0u; i < 32u && low < high; i++) {
        uint middle = (low + high) / 2u;
        if (start_areas[surface.first_triangle + middle] < wanted) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }
    uvec3 corner = specular_triangles[surface.first_triangle + low].corner;
    float root = sqrt(to_unit(combine(seed, 3u)));
    float part = to_unit(combine(seed, 4u));
    vec3 weight = vec3(1.0 - root, root * (1.0 - part), root * part);
    at = (specular_vertices[corner.x].position - query.point) * weight.x +
         (specular_vertices[corner.y].position - query.point) * weight.y +
         (specular_vertices[corner.z].position - query.point) * weight.z;
    return true;
}
