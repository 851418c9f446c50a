// Adds drops to a simulated sheet, at rest, one invocation a vertex.
#include "shared/index.glsl"
#include "animate/sheet.glsl"

// A Gaussian on the sheet.
struct SheetDrop {
    vec2 centre; // in vertices from the first
    vec2 spacing; // of vertices, in standard deviations
    float height; // m
    uint padding0;
};

layout(set = 0, binding = 0, std430) buffer HeightsNow { vec2 now[]; };
layout(set = 0, binding = 2, std430) buffer Increments { vec2 increments[]; };
layout(set = 0, binding = 3, std430) readonly buffer SheetDrops { SheetDrop drops[]; };
layout(push_constant) uniform DropsPush { SheetPush push; };

float bell(uint at, float centre, float spacing) {
    float deviations = (float(at) - centre) * spacing;
    return exp(-0.5 * deviations * deviations);
}

// Its value here, and the sum of the differences of its neighbours' values to it.
vec2 bell_and_bend(uint at, uint count, float centre, float spacing) {
    uvec2 beside = neighbours(at, count);
    precise float here = bell(at, centre, spacing);
    precise float bend = (bell(beside.x, centre, spacing) - here) + (bell(beside.y, centre, spacing) - here);
    return vec2(here, bend);
}

void main() {
    uint index = linear_index();
    if (index >= push.columns * push.rows) return;
    vec2 height = now[index];
    vec2 increment = increments[index];
    for (uint k = push.first; k < push.first + push.count; k++) {
        SheetDrop drop = drops[k];
        vec2 x = bell_and_bend(index % push.columns, push.columns, drop.centre.x, drop.spacing.x);
        vec2 z = bell_and_bend(index / push.columns, push.rows, drop.centre.y, drop.spacing.y);
        precise float value = drop.height * (x.x * z.x);
        // Half a step's acceleration back: the increment is that of half a step ago, and a drop is at rest now.
        precise float acceleration = drop.height * (push.along_x * (x.y * z.x) + push.along_z * (x.x * z.y));
        height = add(height, vec2(value, 0.0));
        increment = add(increment, vec2(-0.5 * acceleration, 0.0));
    }
    now[index] = height;
    increments[index] = increment;
}
