// Triangles whose corners come from a buffer, in clip space.
#include "conformance/draw.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Corners { vec4 corners[]; };

layout(location = 0) flat out uint id;
layout(location = 1) out vec2 weights;

void main() {
    uint corner = uint(gl_VertexIndex) % 3u;
    id = push.first + uint(gl_VertexIndex) / 3u;
    weights = vec2(corner == 1u, corner == 2u);
    gl_Position = corners[3u * push.first + uint(gl_VertexIndex)];
}
