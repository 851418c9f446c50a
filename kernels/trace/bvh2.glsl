// Tracing through a binary tree of boxes.

#include "trace/binary_node.glsl"

layout(set = 1, binding = 0, std430) readonly buffer TraceNodes { BinaryNode trace_nodes[]; };

// Levels of the deepest tree; the builder makes none that is deeper.
const int STACK_SIZE = 64;

const float MISSED = uintBitsToFloat(0x7f800000u);

// Where the ray enters the box; MISSED where it does not.
float enter_box(BinaryNode node, ObjectRay ray) {
    vec3 low = node.low - ray.origin;
    vec3 high = node.high - ray.origin;
    float margin = box_margin(max(abs(low), abs(high)));
    low = (low - margin) * ray.inverse;
    high = (high + margin) * ray.inverse;
    vec3 enter = min(low, high);
    vec3 leave = max(low, high);
    float first = max(max(enter.x, enter.y), max(enter.z, ray.t_min));
    float last = min(min(leave.x, leave.y), min(leave.z, ray.t_max));
    return first <= last ? first : MISSED;
}

void trace_mesh(uint root, uint instance, bool any_hit, inout ObjectRay ray, inout Candidate found) {
    uint stack[STACK_SIZE];
    int depth = 0;
    uint at = root;
    uint limit = uint(trace_nodes.length());
    for (uint visited = 0u; visited < limit; ++visited) {
        BinaryNode node = trace_nodes[at];
        bool pop = true;
        if (node.triangles == 0u) {
            float left = enter_box(trace_nodes[node.first], ray);
            float right = enter_box(trace_nodes[node.first + 1u], ray);
            uint near = node.first + (right < left ? 1u : 0u);
            at = near;
            pop = min(left, right) == MISSED;
            if (max(left, right) != MISSED) {
                stack[min(depth, STACK_SIZE - 1)] = near ^ node.first ^ (node.first + 1u);
                depth += 1;
            }
        } else {
            for (uint i = 0u; i < node.triangles; ++i) {
                intersect_triangle(node.first + i, instance, ray, found);
            }
            if (any_hit && found.instance != NO_INSTANCE) {
                return;
            }
        }
        if (pop) {
            if (depth == 0) {
                return;
            }
            depth -= 1;
            at = stack[min(depth, STACK_SIZE - 1)];
        }
    }
}
