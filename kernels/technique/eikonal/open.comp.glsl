// Takes the marks off values that were given.
#include "shared/index.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) buffer EikonalValues { uint values[]; };
layout(push_constant) uniform EikonalPush {
    uint volume;
} push;

void main() {
    uvec3 cells = volumes[push.volume].grid.cells;
    uint cell = linear_index();
    if (cell >= cells.x * cells.y * cells.z) return;
    values[cell] &= ~GIVEN;
}
