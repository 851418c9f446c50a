// Watertight ray-triangle intersection after Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", 2013.
//
// Space is sheared until the ray is the z axis; a vertex's place in the plane then depends on the vertex and the ray
// alone, and the triangles that share it agree. Their double-precision fallback is not needed to have no gaps: rounding
// is monotonic, so that sign(fl(ab) - fl(cd)) is the true sign or zero, and zero counts as inside. What is accepted thus
// covers the exact closed triangles, edges and vertices included. It holds only without fused multiply-add in the edge
// functions, hence `precise`.

#include "trace/leaf_triangle.glsl"

layout(set = 1, binding = 1, std430) readonly buffer TraceTriangles { LeafTriangle trace_triangles[]; };

// A ray in object space, made ready.
struct ObjectRay {
    vec3 origin;
    float t_min;
    vec3 inverse; // of the direction; finite
    float t_max; // shrinks to the closest hit
    vec3 shear_x; // rows that take (vertex - origin) to the plane across the ray, and to t
    vec3 shear_y;
    vec3 shear_z;
};

// The unit roundoff of f32 times the roundings (divisions count for more) on the way from a vertex or a box to what is
// compared.
const float ROUNDING = 16.0 * 5.9604645e-8;

// What a box is widened by on every side; `reach`: how far along the axes its farthest corner is from the origin. A ray
// that the rounded triangle test accepts just outside of the exact triangle must meet the triangle's box, and so must
// one that runs within a side of it, whose direction was not exactly zero across it (Ize, "Robust BVH Ray Traversal",
// 2013, has the margin for the box alone).
float box_margin(vec3 reach) {
    return ROUNDING * max(reach.x, max(reach.y, reach.z));
}

// What was hit so far, in any instance.
struct Candidate {
    uint triangle; // into trace_triangles
    uint instance;
    vec2 barycentrics;
};

// Below this, relative to the largest, a component of a direction shows in no f32 result, and its inverse overflows.
const float LEAST_DIRECTION = 1e-18;

// 1 / direction without infinities.
vec3 finite_inverse(vec3 direction) {
    vec3 size = abs(direction);
    vec3 least = vec3(LEAST_DIRECTION * max(size.x, max(size.y, size.z)));
    return mix(vec3(1.0), vec3(-1.0), lessThan(direction, vec3(0.0))) / max(size, least);
}

ObjectRay object_ray(Instance instance, Ray ray) {
    ObjectRay r;
    r.origin = transform_point(instance.to_object, ray.origin);
    r.t_min = ray.t_min;
    r.t_max = ray.t_max;
    vec3 direction = transform_vector(instance.to_object, ray.direction);
    vec3 size = abs(direction);
    r.inverse = finite_inverse(direction);
    if (size.x >= size.y && size.x >= size.z) {
        float inverse = 1.0 / direction.x;
        r.shear_x = vec3(-direction.y * inverse, 1.0, 0.0);
        r.shear_y = vec3(-direction.z * inverse, 0.0, 1.0);
        r.shear_z = vec3(inverse, 0.0, 0.0);
    } else if (size.y >= size.z) {
        float inverse = 1.0 / direction.y;
        r.shear_x = vec3(0.0, -direction.z * inverse, 1.0);
        r.shear_y = vec3(1.0, -direction.x * inverse, 0.0);
        r.shear_z = vec3(0.0, inverse, 0.0);
    } else {
        float inverse = 1.0 / direction.z;
        r.shear_x = vec3(1.0, 0.0, -direction.x * inverse);
        r.shear_y = vec3(0.0, 1.0, -direction.y * inverse);
        r.shear_z = vec3(0.0, 0.0, inverse);
    }
    return r;
}

// Keeps the triangle if it is the closest so far.
void intersect_triangle(uint index, uint instance, inout ObjectRay ray, inout Candidate found) {
    precise vec3 a = trace_triangles[index].a - ray.origin;
    precise vec3 b = trace_triangles[index].b - ray.origin;
    precise vec3 c = trace_triangles[index].c - ray.origin;
    precise float ax = ray.shear_x.x * a.x + ray.shear_x.y * a.y + ray.shear_x.z * a.z;
    precise float ay = ray.shear_y.x * a.x + ray.shear_y.y * a.y + ray.shear_y.z * a.z;
    precise float bx = ray.shear_x.x * b.x + ray.shear_x.y * b.y + ray.shear_x.z * b.z;
    precise float by = ray.shear_y.x * b.x + ray.shear_y.y * b.y + ray.shear_y.z * b.z;
    precise float cx = ray.shear_x.x * c.x + ray.shear_x.y * c.y + ray.shear_x.z * c.z;
    precise float cy = ray.shear_y.x * c.x + ray.shear_y.y * c.y + ray.shear_y.z * c.z;
    precise float u = cx * by - cy * bx;
    precise float v = ax * cy - ay * cx;
    precise float w = bx * ay - by * ax;
    float determinant = u + v + w;
    bool inside = (min(u, min(v, w)) >= 0.0 || max(u, max(v, w)) <= 0.0) && determinant != 0.0;
    float inverse = 1.0 / determinant;
    float t = (u * dot(ray.shear_z, a) + v * dot(ray.shear_z, b) + w * dot(ray.shear_z, c)) * inverse;
    if (inside && t > ray.t_min && t < ray.t_max) {
        ray.t_max = t;
        found = Candidate(index, instance, vec2(v, w) * inverse);
    }
}
