// The three rays of a leaf in one sheet.
#include "technique/beams/vertex.glsl"
#include "technique/beams/leaf.glsl"

struct BeamEdges {
    uvec3 records; // NO_RECORD where the light does not go that way
    vec3 normal;   // unit, the way the light goes
    bool complete; // three rays that bound a beam
    bool drawn;    // lit, and they do not part by more than a plane across all of them can take
};

// Cosine between an edge and the beam's normal below which a beam is not drawn: planes across it would meet the edge ever
// farther away.
const float LEAST_COSINE = 0.1;

// Of its rays, those that something opaque close before the specular surface has.
uint hidden_corners(BeamLeaf leaf) {
    return lattice_places[leaf.vertices.x].hidden + lattice_places[leaf.vertices.y].hidden +
           lattice_places[leaf.vertices.z].hidden;
}

BeamEdges edges_of(BeamLeaf leaf, uint sheet) {
    BeamEdges e = BeamEdges(uvec3(record_of(leaf.vertices.x, sheet), record_of(leaf.vertices.y, sheet),
                                  record_of(leaf.vertices.z, sheet)), vec3(0.0), false, false);
    if (any(equal(e.records, uvec3(NO_RECORD)))) return e;
    uvec3 sources = uvec3(beam_vertices[e.records.x].source, beam_vertices[e.records.y].source,
                          beam_vertices[e.records.z].source);
    uvec3 in_media = uvec3(beam_vertices[e.records.x].medium, beam_vertices[e.records.y].medium,
                           beam_vertices[e.records.z].medium);
    e.complete = sources.x == sources.y && sources.x == sources.z && in_media.x == in_media.y && in_media.x == in_media.z;
    vec3 a = beam_vertices[e.records.x].direction;
    vec3 b = beam_vertices[e.records.y].direction;
    vec3 c = beam_vertices[e.records.z].direction;
    vec3 sum = a + b + c;
    e.normal = sum / max(length(sum), 1e-6);
    e.drawn = e.complete && hidden_corners(leaf) < 3u && is_lit(leaf) && min(dot(a, e.normal), min(dot(b, e.normal), dot(c, e.normal))) >= LEAST_COSINE;
    return e;
}

bool is_diffuse(uint instance) {
    return instance != NO_INSTANCE && !goes_on(instance);
}

// Whether the beam brings light to anything on its way: a medium that scatters, or a diffuse surface. Beams inside of clear
// glass and those to the sky are half of all in a pool.
bool brings_light(BeamEdges e) {
    if (!e.drawn) return false;
    vec3 scattering = media[beam_vertices[e.records.x].medium].scattering;
    return any(greaterThan(scattering, vec3(0.0))) || is_diffuse(beam_vertices[e.records.x].target) ||
           is_diffuse(beam_vertices[e.records.y].target) || is_diffuse(beam_vertices[e.records.z].target);
}
