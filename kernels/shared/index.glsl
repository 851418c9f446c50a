// One-dimensional kernels: 64 invocations a workgroup, a multiple of every subgroup size in use and allowed everywhere.
layout(local_size_x = 64) in;

// The invocation's index where a one-dimensional dispatch was folded into two dimensions.
uint linear_index() {
    return gl_GlobalInvocationID.x + gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x;
}
