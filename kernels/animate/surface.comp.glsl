// The mesh of a simulated sheet, one invocation a vertex. Normals are those of central differences; at a wall the sheet
// runs into it level.
#include "shared/index.glsl"
#include "shared/vertex.glsl"
#include "animate/normal.glsl"
#include "animate/sheet.glsl"

layout(set = 0, binding = 0, std430) readonly buffer HeightsNow { vec2 now[]; };
layout(set = 0, binding = 4, std430) buffer Vertices { Vertex vertices[]; };
layout(push_constant) uniform SheetMeshPush {
    uint first_vertex;
    uint columns; // of vertices
    uint rows;
    float base;  // m
    float per_x; // 1 / (2 spacing), 1/m
    float per_z;
} push;

void main() {
    uint index = linear_index();
    if (index >= push.columns * push.rows) return;
    uint column = index % push.columns;
    uint row = index / push.columns;
    uvec2 x = neighbours(column, push.columns);
    uvec2 z = neighbours(row, push.rows);
    uint at = row * push.columns;
    vec2 slope = vec2(
        push.per_x * difference(now[at + x.y], now[at + x.x]),
        push.per_z * difference(now[z.y * push.columns + column], now[z.x * push.columns + column])
    );
    vec2 height = add(vec2(push.base, 0.0), now[index]);
    vertices[push.first_vertex + index].position.y = height.x;
    vertices[push.first_vertex + index].normal = normal_of(slope);
}
