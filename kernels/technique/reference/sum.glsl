// Sums of light as integers, so that equal photons give equal bits in whatever order they were sorted.

struct Sum { // 64 bits a channel
    uvec3 low;
    uvec3 high;
};

Sum empty_sum() {
    return Sum(uvec3(0u), uvec3(0u));
}

// `units` below 2^63; the nearest whole number counts. A float has 24 bits, so both halves are exact.
void add(inout Sum sum, vec3 units) {
    units = clamp(units + 0.5, 0.0, 9.0e18);
    vec3 high = floor(units / 4294967296.0);
    uvec3 carry;
    sum.low = uaddCarry(sum.low, uvec3(units - high * 4294967296.0), carry);
    sum.high += uvec3(high) + carry;
}

// In units.
vec3 total(Sum sum) {
    return vec3(sum.high) * 4294967296.0 + vec3(sum.low);
}
