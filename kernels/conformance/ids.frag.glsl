// The triangle's number and, as bits, what a mode asks for.
#include "conformance/draw.glsl"

layout(set = 3, binding = 1, std430) readonly buffer Values { uvec4 values[]; };

layout(location = 0) flat in uint id;
layout(location = 1) in vec2 weights;
layout(location = 0) out uvec2 color;

void main() {
    uvec2 found = uvec2(id + 1u, 0u);
    if (push.mode == MODE_INTERPOLATED) found = floatBitsToUint(weights);
    if (push.mode == MODE_DERIVATIVE) found = floatBitsToUint(vec2(dFdx(weights.x), dFdy(weights.y)));
    uvec2 at = uvec2(gl_FragCoord.xy);
    if (push.mode == MODE_BITS) found = values[at.y * push.columns + at.x].xy;
    color = found;
}
