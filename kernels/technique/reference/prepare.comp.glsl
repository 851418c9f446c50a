// Gives a pixel layer its first radius when it first sees a diffuse point, and finds the largest radius in use.
#include "technique/reference/common.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 3, binding = 1, std430) buffer Statistics { Statistic statistics[]; };
layout(push_constant) uniform PreparePush {
    float radius_pixels; // the first radius is this many footprints,
    float least_radius;  // but at least this, m, so that it holds some photons,
    float max_radius;    // and at most this, m
    uint new_grid;       // 1: the photons are about to be sorted anew
} push;

void main() {
    uint slot = linear_index();
    if (slot >= view.width * view.rows * VISIBLE_LAYERS) return;
    float radius2 = statistics[slot].radius2;
    if (radius2 == 0.0 && visible_points[slot].instance != NO_INSTANCE) {
        float radius = min(max(push.radius_pixels * visible_points[slot].footprint, push.least_radius), push.max_radius);
        // Photons that stay sorted from an earlier sample are in cells that fit the radii of then.
        if (push.new_grid == 0u) radius = min(radius, uintBitsToFloat(grid.max_radius));
        radius2 = radius * radius;
        statistics[slot].radius2 = radius2;
    }
    if (push.new_grid == 0u) return;
    // Every radius counts, also where nothing is seen in this sample: a later one may see a point while the photons stay
    // sorted. So does the least first radius, for pixels that have none yet.
    float radius = radius2 > 0.0 ? sqrt(radius2) : min(push.least_radius, push.max_radius);
    atomicMax(grid.max_radius, floatBitsToUint(radius));
}
