// What the light round each ray covers by its neighbours: the signed cross-sections of all beams at that vertex, across the
// ray, added up (after Ernst et al. 2005, who average one function of each triangle's vertex).
#include "technique/beams/vertex.glsl"
#include "technique/beams/leaf.glsl"
#include "technique/beams/ray_area.glsl"


void main() {
    uint index = linear_index();
    uint last = min(state.vertices, settings.vertices);
    if (index >= last * settings.sheets) return;
    uint vertex = index / settings.sheets;
    uint sheet = index % settings.sheets;
    uint own = record_of(vertex, sheet);
    if (own == NO_RECORD) return;
    vec3 way = beam_vertices[own].direction;
    RayArea sum = RayArea(vec3(0.0), 0.0);
    for (uint k = 0u; k < 8u; k++) {
        uint entry = vertex_fans[8u * vertex + k];
        if (entry == 0u) continue;
        BeamLeaf leaf = beam_leaves[entry - 1u];
        uvec3 records = uvec3(record_of(leaf.vertices.x, sheet), record_of(leaf.vertices.y, sheet),
                              record_of(leaf.vertices.z, sheet));
        if (any(equal(records, uvec3(NO_RECORD)))) continue;
        BeamVertex a = beam_vertices[records.x];
        BeamVertex b = beam_vertices[records.y];
        BeamVertex c = beam_vertices[records.z];
        if (!bound_beam(a, b, c)) continue;
        vec3 ab = b.position - a.position;
        vec3 ac = c.position - a.position;
        vec3 ab_way = b.direction - a.direction;
        vec3 ac_way = c.direction - a.direction;
        sum.area += 0.5 * vec3(dot(way, cross(ab, ac)), dot(way, cross(ab, ac_way) + cross(ab_way, ac)),
                               dot(way, cross(ab_way, ac_way)));
        sum.flux += mean(leaf_flux(leaf) * (a.throughput + b.throughput + c.throughput)) / 3.0;
    }
    ray_areas[own] = sum;
}
