// One link of a chain of indirect dispatches: the last workgroup's first invocation says how many groups the next link has.
layout(local_size_x = 4) in;

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };
layout(set = 3, binding = 1, std430) writeonly buffer Arguments { uint arguments[]; };
layout(push_constant) uniform ConformancePush { uint count; uint a; uint b; uint c; } push;

void main() {
    atomicAdd(words[push.a], 1u);
    if (gl_GlobalInvocationID.x == 0u) {
        arguments[3u * (push.a + 1u)] = gl_NumWorkGroups.x + push.b;
        arguments[3u * (push.a + 1u) + 1u] = 1u;
        arguments[3u * (push.a + 1u) + 2u] = 1u;
    }
}
