// Counts and places within a workgroup of 64, in the order of its invocations.
shared uint block_bits[2];

// How many of the invocations before this one are in; call from all of them.
uint place_in_block(bool is_in) {
    uint local = gl_LocalInvocationIndex;
    if (local < 2u) block_bits[local] = 0u;
    barrier();
    if (is_in) atomicOr(block_bits[local / 32u], 1u << (local % 32u));
    barrier();
    uint below = bitCount(block_bits[local / 32u] & ((1u << (local % 32u)) - 1u));
    return local < 32u ? below : below + bitCount(block_bits[0]);
}

// Of a block whose places were asked for.
uint block_total() {
    return bitCount(block_bits[0]) + bitCount(block_bits[1]);
}
