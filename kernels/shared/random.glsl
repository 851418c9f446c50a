// Counter-based numbers: the same counters give the same numbers, on every device.
// renderer/random.rs is the twin of this file on the host, and a test compares them.

uint mix_bits(uint x) { // a 32-bit finaliser with low bias (Wellons 2018)
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

uint combine(uint seed, uint value) {
    return mix_bits(seed ^ (value * 0x9e3779b9u + 0x7f4a7c15u));
}

// Nested uniform scrambling, by the hash of Laine and Karras in Burley's form (2020, Practical Hash-based Owen
// Scrambling).
uint owen_scramble(uint x, uint seed) {
    x = bitfieldReverse(x);
    x ^= x * 0x3d20adeau;
    x += seed;
    x *= (seed >> 16) | 1u;
    x ^= x * 0x05526c56u;
    x ^= x * 0x53a22864u;
    return bitfieldReverse(x);
}

float to_unit(uint x) { // in [0, 1)
    return float(x >> 8) * (1.0 / 16777216.0);
}

// The second dimension of Sobol's sequence; the first is the reversed index.
uint sobol_second(uint index) {
    uint result = 0u;
    uint direction = 0x80000000u;
    for (uint bit = 0u; bit < 32u; bit++) {
        if (((index >> bit) & 1u) != 0u) result ^= direction;
        direction ^= direction >> 1;
    }
    return result;
}

// Point `index` of a scrambled (0,2)-sequence; seeds decorrelate sequences.
vec2 sample_2d(uint index, uint seed) {
    uint shuffled = owen_scramble(index, combine(seed, 1u));
    return vec2(
        to_unit(owen_scramble(bitfieldReverse(shuffled), combine(seed, 2u))),
        to_unit(owen_scramble(sobol_second(shuffled), combine(seed, 3u))));
}

float sample_1d(uint index, uint seed) {
    uint shuffled = owen_scramble(index, combine(seed, 1u));
    return to_unit(owen_scramble(bitfieldReverse(shuffled), combine(seed, 2u)));
}
