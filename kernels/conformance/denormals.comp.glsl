// Small numbers moved without arithmetic, which has to keep them, and through arithmetic, which need not.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Operands { vec4 operands[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Floats { float floats[]; };

vec2 swapped(vec2 pair) {
    return pair.yx;
}

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    vec4 x = operands[i];
    floats[4u * i] = x.x;
    floats[4u * i + 1u] = i % 2u == push.a ? x.x : x.y;
    floats[4u * i + 2u] = swapped(x.xy).y;
    floats[4u * i + 3u] = x.x * x.z;
}
