// As many quads from each point as fit the 1024 components of output that every device with this stage offers: quad k of
// all covers the pixels 0 to k of one row.
#include "conformance/draw.glsl"

layout(points) in;
layout(triangle_strip, max_vertices = 144) out;

// With all members of the block that is there by default, a vertex would have three components more.
out gl_PerVertex { vec4 gl_Position; };

layout(location = 0) flat in uint point[];
layout(location = 0) flat out uint id;
layout(location = 1) out vec2 weights;

void main() {
    for (uint quad = 0u; quad < push.per_point; ++quad) {
        uint number = point[0] * push.per_point + quad;
        float right = 2.0 * float(number + 1u) / float(push.columns) - 1.0;
        for (uint corner = 0u; corner < 4u; ++corner) {
            id = number;
            weights = vec2(0.0);
            // Seen from behind, as what adds up is.
            float x = (corner & 1u) == 0u ? -1.0 : right;
            float y = (corner & 2u) == 0u ? -1.0 : 1.0;
            gl_Position = vec4(x, y, 0.5, 1.0);
            EmitVertex();
        }
        EndPrimitive();
    }
}
