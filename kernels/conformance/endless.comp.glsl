// Ends when word 0 is zero, which it never is: for drivers that are to be seen losing a device.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) coherent volatile buffer Words { uint words[]; };

void main() {
    if (linear_index() >= push.count) return;
    while (words[0] != 0u) {
        atomicAdd(words[1], 1u);
    }
}
