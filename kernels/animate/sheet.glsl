// A simulated sheet: vertices in rows along x, and walls that reflect.

struct SheetPush {
    uint columns; // of vertices, at least 2
    uint rows;    // at least 2
    float along_x; // (speed * step / spacing)^2
    float along_z;
    float gain; // of an increment: what remains of an acceleration under damping
    float loss; // of an increment: the part of it that damping takes in a step
    uint first; // of the drops to be added
    uint count;
};

// The neighbours before and after `at`; behind a wall the sheet is its own mirror image.
uvec2 neighbours(uint at, uint count) {
    return uvec2(at == 0u ? 1u : at - 1u, at + 1u == count ? at - 1u : at + 1u);
}

// Sums of single precision drift within thousands of steps. A number here is the sum of two floats, the second being
// what rounding kept out of the first.
vec2 add(vec2 a, vec2 b) {
    precise float sum = a.x + b.x;
    precise float part = sum - a.x;
    precise float rest = ((a.x - (sum - part)) + (b.x - part)) + (a.y + b.y);
    precise float first = sum + rest;
    precise float second = rest - (first - sum);
    return vec2(first, second);
}

// a - b, a float; exact to its last place however near the two are.
float difference(vec2 a, vec2 b) {
    precise float d = (a.x - b.x) + (a.y - b.y);
    return d;
}
