// Copies a mesh's triangles from its vertices to the leaves of its tree.

#include "shared/scene.glsl"
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "trace/leaf_triangle.glsl"

layout(set = 1, binding = 1, std430) buffer TraceTriangles { LeafTriangle trace_triangles[]; };

layout(push_constant) uniform RefitTrianglesPush {
    uint first; // the mesh's, in trace_triangles
    uint count;
    uint first_vertex; // the mesh's, in the scene's buffers
    uint first_index;
} push;

void main() {
    uint i = linear_index();
    if (i >= push.count) {
        return;
    }
    uint at = push.first + i;
    uint corner = push.first_index + 3u * trace_triangles[at].primitive;
    vec3 a = vertices[push.first_vertex + indices[corner]].position;
    vec3 b = vertices[push.first_vertex + indices[corner + 1u]].position;
    vec3 c = vertices[push.first_vertex + indices[corner + 2u]].position;
    // Were one vertex no number, no box above it would be one. A point is never hit.
    if (!(all_finite(a) && all_finite(b) && all_finite(c))) {
        a = b = c = vec3(0.0);
    }
    trace_triangles[at].a = a;
    trace_triangles[at].b = b;
    trace_triangles[at].c = c;
}
