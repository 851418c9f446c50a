// Word number a + i * b gets a value that follows from its number and the seed c.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) writeonly buffer Words { uint words[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    uint at = push.a + i * push.b;
    words[at] = mix_bits(at ^ push.c);
}
