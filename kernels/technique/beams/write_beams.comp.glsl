// Writes the beams, sheet by sheet, in the order of leaves.
#include "technique/beams/edges.glsl"
#include "technique/beams/beam.glsl"
#include "technique/beams/block.glsl"
#include "technique/beams/ray_area.glsl"
#include "technique/beams/sizes.glsl"

layout(set = 3, binding = 12, std430) readonly buffer BlockSums { uint block_sums[]; };
layout(set = 3, binding = 20, std430) writeonly buffer Beams { Beam beams[]; };
layout(set = 3, binding = 18, std430) buffer BeamHeaders { BeamHeader header; };

// Metres at which the beam's cross-section is so large that an edge that meets nothing may end.
float extent(BeamEdges e, BeamVertex a, BeamVertex b, BeamVertex c) {
    if (settings.extent <= 0.0) return settings.reach;
    float start = abs(dot(e.normal, cross(b.position - a.position, c.position - a.position)));
    float far = abs(dot(e.normal, cross(b.direction - a.direction, c.direction - a.direction)));
    // Far out the cross-section grows with the square of the distance.
    return min(settings.reach, sqrt(start / max(settings.extent * far, 1e-30)));
}

BeamCorner corner_of(BeamVertex ray, RayArea round, vec3 centre, vec3 normal, float extent) {
    float cosine = dot(ray.direction, normal);
    vec3 way = ray.direction / cosine;
    float start = dot(ray.position - centre, normal);
    float reach = ray.target == NO_INSTANCE ? extent : ray.distance;
    return BeamCorner(ray.position - start * way, start, way, start + reach * cosine, round.area, round.flux);
}

void write_beam(uint at, BeamLeaf leaf, BeamEdges e) {
    BeamVertex a = beam_vertices[e.records.x];
    BeamVertex b = beam_vertices[e.records.y];
    BeamVertex c = beam_vertices[e.records.z];
    vec3 centre = (a.position + b.position + c.position) / 3.0;
    float reach = extent(e, a, b, c);
    RayArea round_a = ray_areas[e.records.x];
    RayArea round_b = ray_areas[e.records.y];
    RayArea round_c = ray_areas[e.records.z];
    beams[at].corners[0] = corner_of(a, round_a, centre, e.normal, reach);
    beams[at].corners[1] = corner_of(b, round_b, centre, e.normal, reach);
    beams[at].corners[2] = corner_of(c, round_c, centre, e.normal, reach);
    beams[at].normal = e.normal;
    beams[at].medium = a.medium;
    vec3 passed = round_a.gain * a.throughput + round_b.gain * b.throughput + round_c.gain * c.throughput;
    beams[at].flux = leaf_flux(leaf) * passed / 3.0;
    float least = min(a.distance, min(b.distance, c.distance));
    float most = max(a.distance, max(b.distance, c.distance));
    bool straddles = a.target != b.target || a.target != c.target || most - least > settings.depth * least ||
                     hidden_corners(leaf) > 0u;
    beams[at].flags = straddles ? BEAM_STRADDLES : 0u;
}

void main() {
    uint blocks = max(sizes[SIZE_LEAVES].w, 1u);
    uint group = linear_index() / 64u;
    uint sheet = group / blocks;
    uint index = group % blocks * 64u + gl_LocalInvocationIndex;
    if (linear_index() == 0u) header.count = min(scan_totals[1], settings.beams);
    bool used = sheet < settings.sheets && sheet_counts[sheet] > 0u && index < state.leaves;
    BeamLeaf leaf = beam_leaves[used ? index : 0u];
    BeamEdges e = edges_of(leaf, used ? sheet : 0u);
    used = used && brings_light(e);
    uint before = place_in_block(used);
    if (!used) return;
    uint at = block_sums[group] + before;
    if (at < settings.beams) write_beam(at, leaf, e);
}
