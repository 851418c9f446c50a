// Each invocation takes a place by an atomic counter, word 0, and writes its number there.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Gathered { uint gathered[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    uint place = atomicAdd(words[0], 1u);
    if (place < push.count) gathered[place] = i;
}
