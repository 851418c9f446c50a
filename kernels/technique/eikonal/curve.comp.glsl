// The paper's brightness (Eqs. 3 and 4): how the wave is bent in each cell, mapped by a power. Light goes together where fronts
// are hollow, which is where the Laplacian is below 0. Erratum 16: this is a curvature, not irradiance.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { float values[]; };
layout(set = 3, binding = 6, std430) writeonly buffer EikonalLights { float cell_lights[]; };

#include "technique/eikonal/slopes.glsl"

layout(push_constant) uniform CurvePush {
    uint volume;
    float base; // what an even wave has
    float gain;
    float power;
} push;

void main() {
    EikonalGrid grid = volumes[push.volume].grid;
    uint index = linear_index();
    if (index >= grid.cells.x * grid.cells.y * grid.cells.z) return;
    uint row = index / grid.cells.x;
    ivec3 at = ivec3(index - row * grid.cells.x, row % grid.cells.y, row / grid.cells.y);
    float here = wave_at(grid, at);
    float bright = UNLIT;
    if (here < UNKNOWN) {
        float sum = 0.0;
        for (int side = 0; side < 6; side++) {
            ivec3 step = ivec3(side / 2 == 0 ? 1 : 0, side / 2 == 1 ? 1 : 0, side / 2 == 2 ? 1 : 0) * ((side & 1) * 2 - 1);
            float value = wave_at(grid, at + step);
            float behind = wave_at(grid, at - step);
            // Beyond what is known the wave goes on straight.
            sum += (value < UNKNOWN ? value : behind < UNKNOWN ? 2.0 * here - behind : here) - here;
        }
        float hollow = max(-sum / (grid.index * grid.cell), 0.0);
        bright = push.base + push.gain * pow(hollow, push.power);
        if (!all_finite(vec3(bright))) bright = push.base;
    }
    cell_lights[cell_index(grid, at)] = bright;
}
