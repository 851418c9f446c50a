// What the 64 invocations of a workgroup each say yes to, for all of them: bit i of word i / 32 is invocation i's answer.

const uint VOTERS = 64u;

// Three that take turns, so that a vote needs one barrier: who reads the last one's result may be overtaken by one vote,
// but not by two.
shared uint votes[3][2];
uint vote_turn = 0u;

// Before the first vote, which a barrier has to follow.
void open_votes() {
    if (gl_LocalInvocationIndex < 6u) votes[gl_LocalInvocationIndex / 2u][gl_LocalInvocationIndex % 2u] = 0u;
}

// In uniform control flow only.
uvec2 vote(bool yes) {
    uint lane = gl_LocalInvocationIndex;
    if (yes) atomicOr(votes[vote_turn][lane / 32u], 1u << (lane % 32u));
    barrier();
    uvec2 result = uvec2(votes[vote_turn][0], votes[vote_turn][1]);
    vote_turn = (vote_turn + 1u) % 3u;
    uint next = (vote_turn + 1u) % 3u;
    if (lane < 2u) votes[next][lane] = 0u;
    return result;
}

bool any_bit(uvec2 bits) {
    return (bits.x | bits.y) != 0u;
}

// Takes the lowest bit away and returns its number.
uint take_bit(inout uvec2 bits) {
    if (bits.x != 0u) {
        uint low = uint(findLSB(bits.x));
        bits.x &= bits.x - 1u;
        return low;
    }
    uint high = uint(findLSB(bits.y));
    bits.y &= bits.y - 1u;
    return 32u + high;
}
