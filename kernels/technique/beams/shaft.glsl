// Four planes along a direction, and two across it: what is round rays that go roughly the same way.
#include "shared/math.glsl"

struct Shaft {
    vec3 axis;    // unit
    vec3 across[2];
    vec2 ends;    // along the axis, m: near and far
    vec4 at_near; // bounds across: low and high along across[0], then across[1]
    vec4 at_far;
};

// A ray more than this off the mean direction would make the planes wide; then they are parallel, round all ends.
const float LEAST_COSINE = 0.2;

// What rounding moves bounds by, of coordinates as large as these.
void add_slack(inout Shaft shaft) {
    float slack = 1e-5 * (abs(shaft.ends.x) + abs(shaft.ends.y) + dot(abs(shaft.at_far) + abs(shaft.at_near), vec4(1.0)));
    shaft.ends += vec2(-slack, slack);
    shaft.at_near += slack * vec4(-1.0, 1.0, -1.0, 1.0);
    shaft.at_far += slack * vec4(-1.0, 1.0, -1.0, 1.0);
}

// A corner, 0 to 3, at a place along the axis.
vec3 shaft_corner(Shaft shaft, uint corner, float along) {
    float part = (along - shaft.ends.x) / max(shaft.ends.y - shaft.ends.x, 1e-20);
    vec4 bounds = mix(shaft.at_near, shaft.at_far, part);
    float u = (corner & 1u) == 0u ? bounds.x : bounds.y;
    float v = (corner & 2u) == 0u ? bounds.z : bounds.w;
    return u * shaft.across[0] + v * shaft.across[1] + along * shaft.axis;
}
