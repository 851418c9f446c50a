// Fits the boxes of one level of a binary tree.

#include "shared/index.glsl"
#include "trace/leaf_triangle.glsl"
#include "trace/binary_node.glsl"
#include "trace/refit_level.glsl"

layout(set = 1, binding = 0, std430) buffer TraceNodes { BinaryNode trace_nodes[]; };
layout(set = 1, binding = 1, std430) readonly buffer TraceTriangles { LeafTriangle trace_triangles[]; };

void main() {
    uint i = linear_index();
    if (i >= push.count) {
        return;
    }
    uint at = push.root + refit_order[push.first + i];
    uint first = trace_nodes[at].first;
    vec3 low;
    vec3 high;
    if (trace_nodes[at].triangles == 0u) {
        low = min(trace_nodes[first].low, trace_nodes[first + 1u].low);
        high = max(trace_nodes[first].high, trace_nodes[first + 1u].high);
    } else {
        LeafTriangle leaf = trace_triangles[first];
        low = min(leaf.a, min(leaf.b, leaf.c));
        high = max(leaf.a, max(leaf.b, leaf.c));
    }
    trace_nodes[at].low = low;
    trace_nodes[at].high = high;
}
