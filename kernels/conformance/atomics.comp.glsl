// Every kind of atomic that kernels use, on slots that many invocations share. Slot s has eight words from 8 s on.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    uint slot = 8u * (i % push.a);
    uint value = mix_bits(i);
    // A sum of 64 bits in two words, as photons are added up: who overflows the lower word carries.
    uint before = atomicAdd(words[slot], value);
    if (before + value < before) atomicAdd(words[slot + 1u], 1u);
    atomicMin(words[slot + 2u], value);
    atomicMax(words[slot + 3u], value);
    atomicOr(words[slot + 4u], 1u << (value % 32u));
    atomicXor(words[slot + 5u], value);
    // A counter by compare and swap, in as many tries as it may take.
    uint seen = words[slot + 6u];
    for (uint turn = 0u; turn < push.b; ++turn) {
        uint found = atomicCompSwap(words[slot + 6u], seen, seen + 1u);
        if (found == seen) {
            atomicAdd(words[slot + 7u], 1u);
            turn = push.b - 1u;
        }
        seen = found;
    }
}
