// Draws ids of what a light sees, so that texels' middles fall on the points of its lattice.
#include "shared/light_view.glsl"

layout(set = 3, binding = 0, std430) readonly buffer LightViews { LightView light_views[]; };
layout(push_constant) uniform LightViewPush {
    uint view;
    uint instance;
    uint rastered;
    uint padding0;
} push;

layout(location = 0) flat out uvec2 ids;

// Metres, as in frame/visibility.
const float NEAR = 1e-4;

void main() {
    LightView v = light_views[push.view];
    Instance instance = instances[push.instance];
    uint primitive = uint(gl_VertexIndex) / 3u;
    Vertex vertex = vertices[instance.first_vertex + indices[instance.first_index + uint(gl_VertexIndex)]];
    vec3 way = transform_point(instance.to_world, vertex.position) - v.origin;
    float ahead = dot(way, v.forward);
    float w = v.perspective != 0u ? ahead : 1.0;
    vec2 size = vec2(v.columns, v.rows);
    // In texels from the first one's middle, times w; half a texel of border lies round the lattice.
    vec2 texel = (vec2(dot(way, v.right), dot(way, v.up)) - v.lower * w) * (size - 1.0) / (v.upper - v.lower);
    vec2 clip = 2.0 * (texel + 0.5 * w) / size - w;
    gl_Position = vec4(clip, v.perspective != 0u ? NEAR : 1.0 - ahead / v.reach, w);
    ids = uvec2(push.instance + 1u, primitive);
}
