// What the light round each ray covers by its neighbours: the signed cross-sections of all beams at that vertex, across the
// ray, added up (after Ernst et al. 2005, who average one function of each triangle's vertex). At outlines, beams that lack
// an edge are not drawn; what the vertex's ray has of their light is given to the others round it, so that no light is lost.
#include "technique/beams/edges.glsl"
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
    vec3 area = vec3(0.0);
    float all = 0.0;
    float drawn = 0.0;
    for (uint k = 0u; k < 8u; k++) {
        uint entry = vertex_fans[8u * vertex + k];
        if (entry == 0u) continue;
        BeamLeaf leaf = beam_leaves[entry - 1u];
        BeamEdges e = edges_of(leaf, sheet);
        float power = mean(leaf_flux(leaf));
        all += power;
        if (e.drawn) drawn += power;
        if (!e.complete) continue;
        BeamVertex a = beam_vertices[e.records.x];
        BeamVertex b = beam_vertices[e.records.y];
        BeamVertex c = beam_vertices[e.records.z];
        vec3 ab = b.position - a.position;
        vec3 ac = c.position - a.position;
        vec3 ab_way = b.direction - a.direction;
        vec3 ac_way = c.direction - a.direction;
        area += 0.5 * vec3(dot(way, cross(ab, ac)), dot(way, cross(ab, ac_way) + cross(ab_way, ac)),
                           dot(way, cross(ab_way, ac_way)));
    }
    float gain = drawn > 0.0 ? all / drawn : 0.0;
    // Of a beam that has an edge behind something opaque, what is before that has all of its light.
    if (lattice_places[vertex].hidden != 0u) gain = 1.0;
    ray_areas[own] = RayArea(area, all * mean(beam_vertices[own].throughput), gain, 0u, 0u, 0u);
}
