// One level of a mesh's tree. Levels are counted from the leaves, so that a node's children are all done before it.

layout(set = 2, binding = 0, std430) readonly buffer RefitOrder { uint refit_order[]; }; // nodes, level after level

layout(push_constant) uniform RefitPush {
    uint first; // of the level, in refit_order
    uint count;
    uint root; // the mesh's first node, in trace_nodes
    uint padding0;
} push;
