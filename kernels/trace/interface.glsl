// One way to trace rays, whichever back-end answers; everything that traces includes this file and calls these.
// Set 1 belongs to the tracer. Hits are strictly between t_min and t_max, on both sides of triangles.
//
// Keep one call site a kernel (a flag or a loop around it): lavapipe's compile time grows with each.

#include "shared/scene.glsl"

struct Ray { // world space
    vec3 origin;
    float t_min; // in units of `direction`, at least 0
    vec3 direction; // of any length but zero
    float t_max; // in units of `direction`; may be infinite
};

struct Hit {
    float t; // in units of the ray's direction
    uint instance; // NO_INSTANCE: nothing was hit
    uint primitive; // triangle of the instance's mesh
    vec2 barycentrics; // weights of the triangle's second and third vertex
};

Hit no_hit(Ray ray) {
    return Hit(ray.t_max, NO_INSTANCE, 0u, vec2(0.0));
}

// By bits: a compiler may assume that arithmetic never meets infinities.
bool is_finite(vec3 v) {
    uvec3 exponents = floatBitsToUint(v) & 0x7f800000u;
    return all(notEqual(exponents, uvec3(0x7f800000u)));
}

// Rays with a number that is none, or with no direction, hit nothing.
bool is_traceable(Ray ray) {
    return is_finite(ray.origin) && is_finite(ray.direction) && any(notEqual(ray.direction, vec3(0.0))) &&
           ray.t_min < ray.t_max;
}

#if defined(TRACE_RAY_QUERY)
#include "trace/ray_query.glsl"
#else
#include "trace/triangle.glsl"
#if defined(TRACE_CWBVH)
#include "trace/cwbvh.glsl"
#else
#include "trace/bvh2.glsl"
#endif
#include "trace/top_level.glsl"
#endif

// Any hit answers where `any_hit` is set, else the closest. Instances that share no bit with `mask` are not there.
Hit trace(Ray ray, uint mask, bool any_hit) {
    if (!is_traceable(ray)) {
        return no_hit(ray);
    }
    ray.t_min = max(ray.t_min, 0.0);
    return trace_scene(ray, mask, any_hit);
}

Hit trace_closest(Ray ray, uint mask) {
    return trace(ray, mask, false);
}

bool trace_occluded(Ray ray, uint mask) {
    return trace(ray, mask, true).instance != NO_INSTANCE;
}
