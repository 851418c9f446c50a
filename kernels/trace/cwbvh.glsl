// Tracing through an eight-wide tree with quantised boxes, after Ylitie, Karras and Laine, "Efficient Incoherent Ray
// Traversal on GPUs Through Compressed Wide BVHs", 2017.

#include "trace/wide_node.glsl"

layout(set = 1, binding = 0, std430) readonly buffer TraceNodes { WideNode trace_nodes[]; };

// Levels of the deepest tree; the builder makes none that is deeper.
const int STACK_SIZE = 32;

// Distances along the ray to the boxes of a node: plane q is at q * step + low or high, which are padded apart.
struct Grid {
    vec3 step;
    vec3 low;
    vec3 high;
    float t_min;
    float t_max;
};

// Four slots: where each one's bits go among the hits, and what they are.
struct Slots {
    uint places;
    uint bits;
};

// Nodes, alone in having both of bits 3 and 4, are sorted into the order in which the ray meets their octants.
Slots slots_of(uint meta, uint order) {
    uint nodes = (meta & meta << 1 & 0x10101010u) >> 4;
    return Slots((meta ^ nodes * order) & 0x1f1f1f1fu, meta >> 5 & 0x07070707u);
}

uint hit_bits(Grid grid, Slots slots, uint shift, uvec3 near, uvec3 far) {
    vec3 enter = vec3(near >> shift & 255u) * grid.step + grid.low;
    vec3 leave = vec3(far >> shift & 255u) * grid.step + grid.high;
    float first = max(max(enter.x, enter.y), max(enter.z, grid.t_min));
    float last = min(min(leave.x, leave.y), min(leave.z, grid.t_max));
    uint bits = (slots.bits >> shift & 7u) << (slots.places >> shift & 31u);
    return first <= last ? bits : 0u;
}

uint hit_bits(Grid grid, Slots slots, uvec3 near, uvec3 far) {
    return hit_bits(grid, slots, 0u, near, far) | hit_bits(grid, slots, 8u, near, far) |
           hit_bits(grid, slots, 16u, near, far) | hit_bits(grid, slots, 24u, near, far);
}

// Children that the ray meets: nodes in bits 24 to 31, the farthest lowest; triangles of leaves below.
uint intersect_node(WideNode node, ObjectRay ray, uint order) {
    Grid grid;
    uvec3 exponents = uvec3(node.scales, node.scales >> 8, node.scales >> 16) & 255u;
    vec3 size = uintBitsToFloat(exponents << 23);
    vec3 offset = node.origin - ray.origin;
    vec3 reach = abs(offset) + 255.0 * size;
    vec3 pad = box_margin(reach) * abs(ray.inverse);
    vec3 start = offset * ray.inverse;
    grid.step = size * ray.inverse;
    grid.low = start - pad;
    grid.high = start + pad;
    grid.t_min = ray.t_min;
    grid.t_max = ray.t_max;
    uvec2 near_x = ray.inverse.x < 0.0 ? node.x.zw : node.x.xy;
    uvec2 near_y = ray.inverse.y < 0.0 ? node.y.zw : node.y.xy;
    uvec2 near_z = ray.inverse.z < 0.0 ? node.z.zw : node.z.xy;
    uvec2 far_x = ray.inverse.x < 0.0 ? node.x.xy : node.x.zw;
    uvec2 far_y = ray.inverse.y < 0.0 ? node.y.xy : node.y.zw;
    uvec2 far_z = ray.inverse.z < 0.0 ? node.z.xy : node.z.zw;
    uvec3 near = uvec3(near_x.x, near_y.x, near_z.x);
    uvec3 far = uvec3(far_x.x, far_y.x, far_z.x);
    uint hits = hit_bits(grid, slots_of(node.meta.x, order), near, far);
    near = uvec3(near_x.y, near_y.y, near_z.y);
    far = uvec3(far_x.y, far_y.y, far_z.y);
    return hits | hit_bits(grid, slots_of(node.meta.y, order), near, far);
}

void trace_mesh(uint root, uint instance, bool any_hit, inout ObjectRay ray, inout Candidate found) {
    uvec2 stack[STACK_SIZE];
    int depth = 0;
    uint order = (ray.inverse.x < 0.0 ? 0u : 4u) | (ray.inverse.y < 0.0 ? 0u : 2u) | (ray.inverse.z < 0.0 ? 0u : 1u);
    // Nodes still to visit: the first of their siblings, and their bits over the siblings' mask. The root is an only
    // child in a slot of its own.
    uvec2 group = uvec2(root, 0x80000000u);
    uint limit = uint(trace_nodes.length());
    // One loop: going down until there are triangles first, so that neighbouring rays test theirs together, costs shadow
    // rays 20 % on lavapipe and gains nothing for others.
    for (uint visited = 0u; visited < limit; ++visited) {
        uint bit = uint(findMSB(group.y));
        group.y &= ~(1u << bit);
        uint slot = (bit - 24u) ^ order;
        uint index = group.x + bitCount(group.y & ~(0xffffffffu << slot) & 255u);
        if (group.y > 0x00ffffffu) {
            stack[min(depth, STACK_SIZE - 1)] = group;
            depth += 1;
        }
        WideNode node = trace_nodes[index];
        uint hits = intersect_node(node, ray, order);
        for (uint triangles = hits & 0x00ffffffu; triangles != 0u; triangles &= triangles - 1u) {
            intersect_triangle(node.first_triangle + uint(findLSB(triangles)), instance, ray, found);
        }
        group = uvec2(node.first_node, (hits & 0xff000000u) | node.scales >> 24);
        if (any_hit && found.instance != NO_INSTANCE) {
            return;
        }
        if (group.y <= 0x00ffffffu) {
            if (depth == 0) {
                return;
            }
            depth -= 1;
            group = stack[min(depth, STACK_SIZE - 1)];
        }
    }
}
