// Writes the leaves, in the order of nodes, and enters each in the fans of its corners.
#include "technique/beams/nodes.glsl"
#include "technique/beams/leaf.glsl"
#include "technique/beams/block.glsl"

layout(set = 3, binding = 12, std430) readonly buffer BlockSums { uint block_sums[]; };
layout(push_constant) uniform JitterPush {
    vec2 jitter; // of the lattice, in coarse cells
    uint padding0;
    uint padding1;
} push;

// Edges of the mesh run along eight directions: which one, counter-clockwise from the columns' axis.
uint eighth(ivec2 way) {
    if (way.y == 0) return way.x > 0 ? 0u : 4u;
    if (way.x == 0) return way.y > 0 ? 2u : 6u;
    if (way.y > 0) return way.x > 0 ? 1u : 3u;
    return way.x > 0 ? 7u : 5u;
}

// W through the triangle, by a quadrature that is exact for quadratics.
vec3 power_through(LightView v, ivec2 a, ivec2 b, ivec2 c) {
    vec2 cell = coarse_cell(v) / float(1u << settings.levels);
    vec2 corners[3] = vec2[3](drawn_in(vec2(a), push.jitter), drawn_in(vec2(b), push.jitter),
                              drawn_in(vec2(c), push.jitter));
    vec2 ab = corners[1] - corners[0];
    vec2 ac = corners[2] - corners[0];
    float area = 0.5 * abs(ab.x * ac.y - ab.y * ac.x) * cell.x * cell.y;
    Light light = lights[v.light];
    vec3 sum = light_power(v, light, lattice_chart(v, 0.5 * (corners[0] + corners[1]), push.jitter)) +
               light_power(v, light, lattice_chart(v, 0.5 * (corners[1] + corners[2]), push.jitter)) +
               light_power(v, light, lattice_chart(v, 0.5 * (corners[2] + corners[0]), push.jitter));
    return area / 3.0 * sum;
}

void main() {
    uint place = linear_index();
    uint view;
    ivec2 a, b, c;
    bool found = place < leaf_places() && leaf_at(place, view, a, b, c);
    uint before = place_in_block(found);
    if (place >= leaf_places()) return;
    uint index = block_sums[place / 64u] + before;
    uint cell = cell_of_place(place);
    if (place % (8u * nodes_per_cell()) == 0u) cell_leaves[cell] = min(index, settings.leaves);
    if (place + 1u == leaf_places()) cell_leaves[cell + 1u] = min(index + uint(found), settings.leaves);
    if (!found || index >= settings.leaves) return;
    uvec3 vertices = uvec3(vertex_at(view, a), vertex_at(view, b), vertex_at(view, c));
    // Corners are missing only where there was no room for them; then the leaf is left out.
    bool whole = all(notEqual(vertices, uvec3(NO_VERTEX)));
    vec3 power = whole ? power_through(light_views[view], a, b, c) : vec3(0.0);
    beam_leaves[index] = BeamLeaf(whole ? vertices : uvec3(0u), cell, power, 0u);
    if (!whole) return;
    vertex_fans[8u * vertices.x + eighth(b - a)] = index + 1u;
    vertex_fans[8u * vertices.y + eighth(c - b)] = index + 1u;
    vertex_fans[8u * vertices.z + eighth(a - c)] = index + 1u;
}
