// One link of a chain: half b & 1 of the words is read, the other half written. Each word needs one that another
// workgroup wrote in the link before.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    uint from = (push.b & 1u) * push.count;
    uint to = push.count - from;
    words[to + i] = words[from + (i + push.a) % push.count] * 1664525u + 1013904223u + push.b;
}
