// Exclusive prefix sums of up to 1024 numbers by one workgroup of 64, without subgroup operations.
const uint SCAN_PER_INVOCATION = 16u;
const uint SCAN_PER_GROUP = 1024u;

shared uint scan_sums[64];

// Replaces each invocation's sixteen consecutive numbers by the sum of all before them; returns the group's total.
uint scan_group(inout uint numbers[SCAN_PER_INVOCATION]) {
    uint local = gl_LocalInvocationIndex;
    uint sum = 0u;
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) {
        uint number = numbers[i];
        numbers[i] = sum;
        sum += number;
    }
    scan_sums[local] = sum;
    barrier();
    for (uint step = 1u; step < 64u; step *= 2u) {
        uint before = local >= step ? scan_sums[local - step] : 0u;
        barrier();
        scan_sums[local] += before;
        barrier();
    }
    uint before = scan_sums[local] - sum;
    for (uint i = 0u; i < SCAN_PER_INVOCATION; i++) numbers[i] += before;
    return scan_sums[63];
}
