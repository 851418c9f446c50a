const float PI = 3.14159265358979;

// A unit vector in two 16-bit numbers on the octahedron; the error is below 4e-5 rad.
uint pack_direction(vec3 n) {
    vec2 p = n.xy / (abs(n.x) + abs(n.y) + abs(n.z));
    if (n.z < 0.0) p = (1.0 - abs(p.yx)) * vec2(p.x < 0.0 ? -1.0 : 1.0, p.y < 0.0 ? -1.0 : 1.0);
    return packSnorm2x16(p);
}

vec3 unpack_direction(uint bits) {
    vec2 p = unpackSnorm2x16(bits);
    vec3 n = vec3(p, 1.0 - abs(p.x) - abs(p.y));
    float fold = max(-n.z, 0.0);
    n.x -= n.x < 0.0 ? -fold : fold;
    n.y -= n.y < 0.0 ? -fold : fold;
    return normalize(n);
}

// An orthonormal basis round the unit vector n (Duff et al. 2017, Building an Orthonormal Basis, Revisited).
void basis(vec3 n, out vec3 u, out vec3 v) {
    float s = n.z < 0.0 ? -1.0 : 1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    u = vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x);
    v = vec3(b, s + n.y * n.y * a, -n.y);
}

bool all_finite(vec3 v) {
    // A NaN fails every comparison.
    return all(lessThan(abs(v), vec3(3.0e38)));
}

float mean(vec3 v) {
    return (v.x + v.y + v.z) / 3.0;
}

// The integral of clamp(v, 0, 1).
float clamped_integral(float v) {
    float inside = clamp(v, 0.0, 1.0);
    return 0.5 * inside * inside + max(v - 1.0, 0.0);
}
