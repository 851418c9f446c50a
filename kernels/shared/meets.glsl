// Whether a ray meets the triangle that a rasteriser names.
#include "shared/scene.glsl"

// How far outside of a triangle, in barycentrics, a ray may pass that the rasteriser says sees it. Rounding stays below; a
// rasteriser that places edges by 1/256 pixel does not always, and then the ray decides.
const float MAX_OUTSIDE = 1e-4;

// Barycentrics of the point where the ray meets the triangle's plane. False where it passes outside.
bool meets(uint instance_id, uint primitive, vec3 origin, vec3 direction, out vec2 barycentrics) {
    vec3 a, b, c;
    triangle_corners(instance_id, primitive, a, b, c);
    a -= origin;
    b -= origin;
    c -= origin;
    // Scaled volumes of the ray with each edge; no subtraction of nearly equal hit points.
    vec3 volume = vec3(dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b)));
    vec3 weight = volume / (volume.x + volume.y + volume.z);
    // Also false for the NaN of a ray within the plane.
    bool inside = min(weight.x, min(weight.y, weight.z)) >= -MAX_OUTSIDE;
    weight = max(weight, 0.0);
    barycentrics = inside ? weight.yz / (weight.x + weight.y + weight.z) : vec2(0.0);
    return inside;
}
