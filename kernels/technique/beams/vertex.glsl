// What a lattice vertex's ray becomes. At each specular surface it goes on as two: sheets are the kinds of paths, numbered
// as a binary tree. Sheet 0 was refracted once, 1 reflected once; the two that follow from sheet s are 2s + 2, refracted
// at its end, and 2s + 3, reflected.
#include "technique/beams/common.glsl"

struct BeamVertex {
    vec3 position;   // where the ray leaves its surface
    uint normal;     // packed, shading, of that surface
    vec3 direction;  // unit
    float distance;  // m, to the next surface, or as far as rays are followed
    vec3 throughput; // of the light's power, at `position`
    uint medium;
    uint source;     // instance that it leaves
    uint target;     // instance that it ends on, or NO_INSTANCE
    uint primitive;  // of the target's mesh
    uint barycentrics; // packed
};

const uint NO_RECORD = 0xffffffffu;

layout(set = 3, binding = 5, std430) buffer BeamVertices { BeamVertex beam_vertices[]; };
// Records by vertex and sheet.
layout(set = 3, binding = 6, std430) buffer SheetRecords { uint sheet_records[]; };
// Records of each sheet.
layout(set = 3, binding = 16, std430) buffer SheetCounts { uint sheet_counts[]; };

uint record_of(uint vertex, uint sheet) {
    return sheet_records[vertex * settings.sheets + sheet];
}

vec3 landing(BeamVertex v) {
    return v.position + v.distance * v.direction;
}

bool goes_on(uint instance) {
    return instance != NO_INSTANCE && materials[instances[instance].material].kind != MATERIAL_DIFFUSE;
}

// Whether three rays bound a beam.
bool bound_beam(BeamVertex a, BeamVertex b, BeamVertex c) {
    return a.source == b.source && a.source == c.source && a.medium == b.medium && a.medium == c.medium;
}
