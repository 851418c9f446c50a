#include "shared/scene.glsl"
#include "shared/view.glsl"

layout(push_constant) uniform DrawPush {
    vec2 jitter;
    uint instance;
    uint padding0;
} push;

layout(location = 0) flat out uvec2 ids;

// Metres. With a reversed infinite depth range its size costs no precision.
const float NEAR = 1e-4;

void main() {
    Instance instance = instances[push.instance];
    uint primitive = uint(gl_VertexIndex) / 3u;
    Vertex vertex = vertices[instance.first_vertex + indices[instance.first_index + uint(gl_VertexIndex)]];
    vec3 way = transform_point(instance.to_world, vertex.position) - view.position;
    float w = dot(way, view.forward);
    vec2 clip = vec2(dot(way, view.right) / dot(view.right, view.right), -dot(way, view.up) / dot(view.up, view.up));
    // From the whole picture to this band, and from the pixel's middle to the sample.
    vec2 size = vec2(view.width, view.height);
    vec2 band = vec2(view.width, view.rows);
    vec2 origin = push.jitter - 0.5 + vec2(0.0, view.first_row);
    clip = ((clip + w) * size * 0.5 - origin * w) * 2.0 / band - w;
    gl_Position = vec4(clip, NEAR, w);
    ids = uvec2(push.instance + 1u, primitive);
}
