// W through each cell of a light view's lattice, by its middle; cell (i, j) of view k is at its place in the view's layer.
#include "shared/index.glsl"
#include "shared/light_view.glsl"

layout(set = 3, binding = 0, std430) readonly buffer LightViews { LightView light_views[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Powers { vec4 powers[]; };
layout(push_constant) uniform Push { uint view; };

void main() {
    LightView v = light_views[view];
    uint index = linear_index();
    uvec2 cells = uvec2(v.columns - 1u, v.rows - 1u);
    if (index >= cells.x * cells.y) return;
    vec2 place = (vec2(index % cells.x, index / cells.x) + 0.5) / vec2(cells);
    vec2 size = (v.upper - v.lower) / vec2(cells);
    powers[index] = vec4(light_power(v, lights[v.light], chart_at(v, place)) * size.x * size.y, 0.0);
}
