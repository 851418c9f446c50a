#include "shared/scene.glsl"
#include "shared/project.glsl"

layout(push_constant) uniform DrawPush {
    vec2 jitter;
    uint instance;
    uint padding0;
} push;

layout(location = 0) flat out uvec2 ids;

void main() {
    Instance instance = instances[push.instance];
    uint primitive = uint(gl_VertexIndex) / 3u;
    Vertex vertex = vertices[instance.first_vertex + indices[instance.first_index + uint(gl_VertexIndex)]];
    gl_Position = project(transform_point(instance.to_world, vertex.position), push.jitter);
    ids = uvec2(push.instance + 1u, primitive);
}
