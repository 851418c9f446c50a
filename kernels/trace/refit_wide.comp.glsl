// Fits one level of an eight-wide tree: the grid of each node, and its children's boxes on it.
//
// The grid is the one that the host packs (renderer/trace/wide.rs), and no child's box is cut. That takes exact
// differences: a grid's planes are floats, so that a rounded difference lies on the right side of every plane or on it,
// and where it lies on it, what rounding took away decides. Steps are made from their exponents, and multiplying by them
// rounds nothing.

#include "shared/index.glsl"
#include "trace/leaf_triangle.glsl"
#include "trace/wide_node.glsl"
#include "trace/refit_level.glsl"

struct RefitBox { // a node's own, unrounded
    vec3 low;
    uint padding0;
    vec3 high;
    uint padding1;
};

layout(set = 1, binding = 0, std430) buffer TraceNodes { WideNode trace_nodes[]; };
layout(set = 1, binding = 1, std430) readonly buffer TraceTriangles { LeafTriangle trace_triangles[]; };
layout(set = 2, binding = 1, std430) buffer RefitBoxes { RefitBox refit_boxes[]; }; // of the mesh's nodes

const float HUGE = 3.4028234e38;

// a - b is rounded + rest without an error: the two-sum of Knuth, which holds only as it is written.
struct Difference {
    vec3 rounded;
    vec3 rest;
};

Difference difference(vec3 a, vec3 b) {
    precise vec3 rounded = a - b;
    precise vec3 b_seen = a - rounded;
    precise vec3 a_seen = rounded + b_seen;
    precise vec3 rest = (a - a_seen) + (b_seen - b);
    return Difference(rounded, rest);
}

// The biased exponent of the least power of two of which 255 cover the size. 255 is 1.1111111 * 2^7 in binary.
uint step_exponent(float rounded, float rest) {
    uint bits = floatBitsToUint(rounded);
    uint mantissa = bits & 0x007fffffu;
    bool over = mantissa > 0x007f0000u || (mantissa == 0x007f0000u && rest > 0.0);
    int exponent = int(bits >> 23) - 7 + (over ? 1 : 0);
    return rounded > 0.0 ? uint(clamp(exponent, 1, 253)) : 1u;
}

// The last plane that is not above.
uvec3 planes_below(Difference at, vec3 size, vec3 inverse) {
    vec3 plane = floor(at.rounded * inverse);
    bvec3 above = bvec3(uvec3(equal(plane * size, at.rounded)) & uvec3(lessThan(at.rest, vec3(0.0))));
    return uvec3(clamp(plane - vec3(above), 0.0, 255.0));
}

// The first plane that is not below.
uvec3 planes_above(Difference at, vec3 size, vec3 inverse) {
    vec3 plane = floor(at.rounded * inverse);
    vec3 reached = plane * size;
    uvec3 exact = uvec3(equal(reached, at.rounded)) & uvec3(greaterThan(at.rest, vec3(0.0)));
    bvec3 below = bvec3(uvec3(lessThan(reached, at.rounded)) | exact);
    return uvec3(clamp(plane + vec3(below), 0.0, 255.0));
}

void main() {
    uint i = linear_index();
    if (i >= push.count) {
        return;
    }
    uint index = refit_order[push.first + i];
    WideNode node = trace_nodes[push.root + index];
    uint nodes = node.scales >> 24;
    vec3 lows[8];
    vec3 highs[8];
    vec3 low = vec3(HUGE);
    vec3 high = vec3(-HUGE);
    for (uint slot = 0u; slot < 8u; ++slot) {
        uint meta = node.meta[slot >> 2] >> 8u * (slot & 3u) & 255u;
        lows[slot] = vec3(HUGE);
        highs[slot] = vec3(-HUGE);
        if ((nodes >> slot & 1u) != 0u) {
            RefitBox child = refit_boxes[node.first_node - push.root + bitCount(nodes & ~(0xffffffffu << slot))];
            lows[slot] = child.low;
            highs[slot] = child.high;
        } else {
            uint first = node.first_triangle + (meta & 31u);
            uint count = bitCount(meta >> 5);
            for (uint k = 0u; k < count; ++k) {
                LeafTriangle leaf = trace_triangles[first + k];
                lows[slot] = min(lows[slot], min(leaf.a, min(leaf.b, leaf.c)));
                highs[slot] = max(highs[slot], max(leaf.a, max(leaf.b, leaf.c)));
            }
        }
        low = min(low, lows[slot]);
        high = max(high, highs[slot]);
    }
    Difference extent = difference(high, low);
    uvec3 exponents = uvec3(step_exponent(extent.rounded.x, extent.rest.x),
                            step_exponent(extent.rounded.y, extent.rest.y),
                            step_exponent(extent.rounded.z, extent.rest.z));
    vec3 size = uintBitsToFloat(exponents << 23);
    vec3 inverse = uintBitsToFloat((254u - exponents) << 23);
    uvec4 x = uvec4(0u);
    uvec4 y = uvec4(0u);
    uvec4 z = uvec4(0u);
    for (uint slot = 0u; slot < 8u; ++slot) {
        uint word = slot >> 2;
        uint shift = 8u * (slot & 3u);
        if ((node.meta[word] >> shift & 255u) == 0u) {
            continue;
        }
        uvec3 from = planes_below(difference(lows[slot], low), size, inverse) << shift;
        uvec3 to = planes_above(difference(highs[slot], low), size, inverse) << shift;
        x[word] |= from.x;
        x[word + 2u] |= to.x;
        y[word] |= from.y;
        y[word + 2u] |= to.y;
        z[word] |= from.z;
        z[word + 2u] |= to.z;
    }
    trace_nodes[push.root + index].origin = low;
    trace_nodes[push.root + index].scales = exponents.x | exponents.y << 8 | exponents.z << 16 | nodes << 24;
    trace_nodes[push.root + index].x = x;
    trace_nodes[push.root + index].y = y;
    trace_nodes[push.root + index].z = z;
    refit_boxes[index] = RefitBox(low, 0u, high, 0u);
}
