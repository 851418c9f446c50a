// What becomes of light that has gone together (section 3.3): below a depth, each plane's light is the start of waves in that
// plane, which go as far as the plane is below the depth, times a slope. A line of light parts into two that move away from each
// other, as light does behind a focus. All planes take their steps side by side; a plane that has done its own rests. Light
// does not leave by the sides: next to them, and to cells without light, there is as much as in the cell.
#include "shared/index.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 3, binding = 6, std430) buffer EikonalLights { float cell_lights[]; };
layout(set = 3, binding = 7, std430) buffer EikonalSpread { float other_lights[]; }; // of the step before

layout(push_constant) uniform SpreadPush {
    uint volume;
    uint step;
    float first; // plane in which waves begin
    float slope; // cells across, a plane
    uint last;   // 1: only puts what is in the other buffer into the first
} push;

// Of a cell, the way of a wave in a step; waves in a plane blow up above 0.7.
const float STEP = 0.5;

float light_at(bool other, int cell) {
    return other ? other_lights[cell] : cell_lights[cell];
}

void main() {
    EikonalGrid grid = volumes[push.volume].grid;
    uint index = linear_index();
    if (index >= grid.cells.x * grid.cells.y * grid.cells.z) return;
    uint row = index / grid.cells.x;
    ivec3 at = ivec3(index - row * grid.cells.x, row % grid.cells.y, row / grid.cells.y);
    float way = (float(at.z) - push.first) * push.slope;
    uint steps = way > 0.0 ? uint(ceil(way / STEP)) : 0u;
    int cell = cell_index(grid, at);
    if (push.last != 0u) {
        if (steps > 0u && cell_lights[cell] > UNLIT) cell_lights[cell] = max(light_at((steps & 1u) != 0u, cell), 0.0);
        return;
    }
    if (push.step >= steps) return;
    bool other = (push.step & 1u) != 0u; // holds the light now
    if (!(cell_lights[cell] > UNLIT)) return;
    float here = light_at(other, cell);
    float bend = 0.0;
    for (int side = 0; side < 4; side++) {
        int axis = side >> 1;
        int place = axis == 0 ? at.x : at.y;
        int end = int(axis == 0 ? grid.cells.x : grid.cells.y);
        int way_there = (side & 1) * 2 - 1;
        if (place + way_there < 0 || place + way_there >= end) continue;
        int neighbour = cell + way_there * (axis == 0 ? grid.strides.x : grid.strides.y);
        if (!(cell_lights[neighbour] > UNLIT)) continue;
        bend += light_at(other, neighbour) - here;
    }
    float courant = way / float(steps);
    float next = push.step == 0u ? here + 0.5 * courant * courant * bend
                                 : 2.0 * here - light_at(!other, cell) + courant * courant * bend;
    if (other) cell_lights[cell] = next;
    else other_lights[cell] = next;
}
