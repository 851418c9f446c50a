// Tracing through an eight-wide tree with quantised boxes, after Ylitie, Karras and Laine, "Efficient Incoherent Ray
// Traversal on GPUs Through Compressed Wide BVHs", 2017.

struct WideNode { // object space
    vec3 origin; // of the grid that the children's boxes are on
    uint scales; // biased exponents of the grid's step along x, y, z; then a bit for each child that is a node
    uint first_node; // children that are nodes, in the order of their slots
    uint first_triangle;
    uvec2 meta; // a byte a slot: 0 if empty; node: 32 + 24 + slot; leaf: unary count << 5 | offset of its triangles
    uvec4 x; // a byte a slot: low planes in the first two words, high planes in the others
    uvec4 y;
    uvec4 z;
};

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

uint hit_bits(Grid grid, uint meta, uint order, uint shift, uint near_x, uint near_y, uint near_z, uint far_x, uint far_y, uint far_z) {
    vec3 enter = vec3(uvec3(near_x, near_y, near_z) >> shift & 255u) * grid.step + grid.low;
    vec3 leave = vec3(uvec3(far_x, far_y, far_z) >> shift & 255u) * grid.step + grid.high;
    float first = max(max(enter.x, enter.y), max(enter.z, grid.t_min));
    float last = min(min(leave.x, leave.y), min(leave.z, grid.t_max));
    uint slot = meta >> shift & 255u;
    // Nodes are sorted into the order in which the ray meets their octants.
    uint bit = (slot & 31u) ^ ((slot & 24u) == 24u ? order : 0u);
    return first <= last ? (slot >> 5) << bit : 0u;
}

// Children that the ray meets: nodes in bits 24 to 31, the farthest lowest; triangles of leaves below.
uint intersect_node(WideNode node, ObjectRay ray, uint order) {
    Grid grid;
    uvec3 exponents = uvec3(node.scales, node.scales >> 8, node.scales >> 16) & 255u;
    vec3 size = uintBitsToFloat(exponents << 23);
    vec3 offset = node.origin - ray.origin;
    vec3 reach = abs(offset) + 255.0 * size;
    vec3 pad = ROUNDING * (reach * abs(ray.inverse) + max(reach.x, max(reach.y, reach.z)) * ray.least_inverse);
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
    uint hits = 0u;
#define CHILD(half, shift) \
    hits |= hit_bits(grid, node.meta.half, order, shift, near_x.half, near_y.half, near_z.half, far_x.half, far_y.half, far_z.half);
    CHILD(x, 0u)
    CHILD(x, 8u)
    CHILD(x, 16u)
    CHILD(x, 24u)
    CHILD(y, 0u)
    CHILD(y, 8u)
    CHILD(y, 16u)
    CHILD(y, 24u)
#undef CHILD
    return hits;
}

void trace_mesh(uint root, uint instance, bool any_hit, inout ObjectRay ray, inout Candidate found) {
    uvec2 stack[STACK_SIZE];
    int depth = 0;
    uint order = (ray.inverse.x < 0.0 ? 0u : 4u) | (ray.inverse.y < 0.0 ? 0u : 2u) | (ray.inverse.z < 0.0 ? 0u : 1u);
    // Nodes still to visit: the first of their siblings, and their bits over the siblings' mask. The root is an only
    // child in a slot of its own.
    uvec2 group = uvec2(root, 0x80000000u);
    uint limit = uint(trace_nodes.length());
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
        group = uvec2(node.first_node, (hits & 0xff000000u) | node.scales >> 24);
        for (uint triangles = hits & 0x00ffffffu; triangles != 0u; triangles &= triangles - 1u) {
            intersect_triangle(node.first_triangle + uint(findLSB(triangles)), instance, ray, found);
        }
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
