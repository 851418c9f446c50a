// Takes an instance's vertices to world space.
#include "shared/index.glsl"
#include "shared/scene.glsl"
#include "technique/mnee/surface.glsl"

layout(push_constant) uniform SurfacePush {
    uint instance;
    uint vertices;
} push;

void main() {
    uint index = linear_index();
    if (index >= push.vertices) return;
    Instance instance = instances[push.instance];
    Vertex vertex = vertices[instance.first_vertex + index];
    SpecularVertex world;
    world.position = transform_point(instance.to_world, vertex.position);
    world.padding0 = 0u;
    world.normal = transform_normal(instance.to_object, vertex.normal);
    world.padding1 = 0u;
    specular_vertices[specular_instances[push.instance].first_vertex + index] = world;
}
