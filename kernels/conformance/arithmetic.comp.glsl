// The functions whose precision Vulkan bounds, of four numbers each.
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) readonly buffer Operands { vec4 operands[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Floats { float floats[]; };

const uint RESULTS = 16u;

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    vec4 x = operands[i];
    uint at = RESULTS * i;
    floats[at] = x.x + x.y;
    floats[at + 1u] = x.x - x.y;
    floats[at + 2u] = x.x * x.y;
    floats[at + 3u] = x.x / x.y;
    floats[at + 4u] = sqrt(abs(x.x));
    floats[at + 5u] = inversesqrt(abs(x.x));
    precise float fused = x.x * x.y + x.z;
    floats[at + 6u] = fused;
    precise float area = x.x * x.y - x.z * x.w;
    floats[at + 7u] = area;
    floats[at + 8u] = x.x * x.y + x.z;
    floats[at + 9u] = exp2(x.w);
    floats[at + 10u] = log2(abs(x.x));
    floats[at + 11u] = sin(x.w);
    floats[at + 12u] = cos(x.w);
    floats[at + 13u] = floor(x.w);
    floats[at + 14u] = fma(x.x, x.y, x.z);
    floats[at + 15u] = 1.0 / x.x;
}
