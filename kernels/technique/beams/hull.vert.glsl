// The vertices of hulls that beams/extrude has made.
#include "shared/project.glsl"
#include "technique/beams/hull.glsl"
#include "technique/beams/hull_push.glsl"

layout(set = 3, binding = 4, std430) readonly buffer Hulls { Hull hulls[]; };
layout(location = 0) flat out uint beam_index;

void main() {
    beam_index = uint(gl_VertexIndex) / HULL_VERTICES;
    Hull hull = hulls[beam_index];
    bool none = hull.faces == HULL_NONE;
    // Outside of what is seen.
    gl_Position = none ? vec4(2.0, 2.0, 0.0, 1.0)
                       : project(hull_vertex(hull, uint(gl_VertexIndex) % HULL_VERTICES), push.jitter);
}
