// Marks values near the surface as given; what no triangle reached is left to the wave.
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
    float value = uintBitsToFloat(values[cell]);
    if (value < UNKNOWN) values[cell] |= GIVEN;
    if (value == WANTED) values[cell] = floatBitsToUint(UNKNOWN);
}
