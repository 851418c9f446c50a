// Where each invocation is in its subgroup.
#extension GL_KHR_shader_subgroup_basic : require
#include "conformance/words.glsl"

layout(set = 3, binding = 0, std430) writeonly buffer Words { uint words[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) return;
    words[4u * i] = gl_SubgroupSize;
    words[4u * i + 1u] = gl_NumSubgroups;
    words[4u * i + 2u] = gl_SubgroupID;
    words[4u * i + 3u] = gl_SubgroupInvocationID;
}
