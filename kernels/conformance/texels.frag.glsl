// Each pixel has a colour of its own.
#include "conformance/draw.glsl"

layout(set = 3, binding = 1, std430) readonly buffer Values { vec4 values[]; };

layout(location = 0) flat in uint id;
layout(location = 1) in vec2 weights;
layout(location = 0) out vec4 color;

void main() {
    uvec2 at = uvec2(gl_FragCoord.xy);
    color = values[at.y * push.columns + at.x];
}
