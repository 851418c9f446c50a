// Counts invocations, and how far workgroups reach along each axis.
layout(local_size_x = 4) in;

layout(set = 3, binding = 0, std430) buffer Words { uint words[]; };

void main() {
    atomicAdd(words[0], 1u);
    atomicMax(words[1], gl_WorkGroupID.x + 1u);
    atomicMax(words[2], gl_WorkGroupID.y + 1u);
    atomicMax(words[3], gl_WorkGroupID.z + 1u);
}
