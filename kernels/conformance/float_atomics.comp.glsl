// Adds whole numbers to floats that many invocations share; only where the device has float atomics.
#extension GL_EXT_shader_atomic_float : require
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) buffer Floats { float floats[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    atomicAdd(floats[i % push.a], float(mix_bits(i) % push.b));
}
