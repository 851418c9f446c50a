// Every beam's hull, for rasterisers without a geometry stage; and how many vertices there are to draw.
#include "shared/index.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/hull.glsl"

layout(set = 3, binding = 4, std430) writeonly buffer Hulls { Hull hulls[]; };
// Arguments of an indirect draw: vertices, instances, first vertex, first instance.
layout(set = 3, binding = 5, std430) writeonly buffer HullDraws { uint hull_draws[4]; };
layout(push_constant) uniform ExtrudePush {
    uint capacity; // beams
    uint prism;    // 1: prisms alone
    uint points;   // 1: a vertex a beam, from which the geometry stage makes the hulls
    uint padding0;
} push;

void main() {
    uint index = linear_index();
    uint count = beam_count(push.capacity);
    if (index == 0u) {
        hull_draws[0] = push.points != 0u ? count : HULL_VERTICES * count;
        hull_draws[1] = 1u;
        hull_draws[2] = 0u;
        hull_draws[3] = 0u;
    }
    if (index < count && push.points == 0u) hulls[index] = hull_of(beams[index], push.prism != 0u);
}
