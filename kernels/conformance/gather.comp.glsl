// Copies word number a + i * b to place i.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Words { uint words[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Gathered { uint gathered[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    gathered[i] = words[push.a + i * push.b];
}
