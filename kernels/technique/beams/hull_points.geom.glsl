// A beam's hull from a point.
#include "shared/project.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/hull.glsl"
#include "technique/beams/hull_push.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 24) out;
layout(location = 0) flat in uint beam_of_point[];
layout(location = 0) flat out uint beam_index;

void main() {
    Hull hull = hull_of(beams[beam_of_point[0]], push.prism != 0u);
    if (hull.faces == HULL_NONE) return;
    for (uint vertex = 0u; vertex < HULL_VERTICES; vertex++) {
        beam_index = beam_of_point[0];
        gl_Position = project(hull_vertex(hull, vertex), push.jitter);
        EmitVertex();
        if (vertex % 3u == 2u) EndPrimitive();
    }
}
