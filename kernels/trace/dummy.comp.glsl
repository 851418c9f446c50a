#include "shared/index.glsl"
layout(set = 0, binding = 0, std430) buffer Out { uint data[]; };
layout(push_constant) uniform Push { uint count; uint add; };
void main() { uint i = linear_index(); if (i < count) data[i] = i + add; }
