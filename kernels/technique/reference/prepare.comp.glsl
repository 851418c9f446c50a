// Gives a pixel layer its first radius when it first sees a diffuse point, and finds the largest radius in use.
#include "technique/reference/common.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 3, binding = 1, std430) buffer Statistics { Statistic statistics[]; };
layout(push_constant) uniform PreparePush {
    float radius_pixels; // of the first radius
    float max_radius;    // m; a bound for grazing views of far surfaces
} push;

void main() {
    uint slot = linear_index();
    if (slot >= view.width * view.rows * VISIBLE_LAYERS) return;
    if (visible_points[slot].instance == NO_INSTANCE) return;
    float radius2 = statistics[slot].radius2;
    if (radius2 == 0.0) {
        float radius = clamp(push.radius_pixels * visible_points[slot].footprint, 1e-6, push.max_radius);
        radius2 = radius * radius;
        statistics[slot].radius2 = radius2;
    }
    atomicMax(grid.max_radius, floatBitsToUint(sqrt(radius2)));
}
