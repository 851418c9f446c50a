// Refracts light at each vertex of an instance and finds where it lands. Other specular surfaces are looked through: a
// path that meets them is another technique's.
#include "shared/index.glsl"
#include "shared/optics.glsl"
#include "technique/mnee/footprints.glsl"
#include "trace/interface.glsl"

layout(push_constant) uniform LandingPush {
    uint instance;
    uint vertices;
    uint light;
    float far; // m: where light lands that meets nothing
} push;

void main() {
    uint index = linear_index();
    if (index >= push.vertices) return;
    uint at = specular_instances[push.instance].first_vertex + index;
    SpecularVertex vertex = specular_vertices[at];
    Light light = lights[push.light];
    Material material = materials[instances[push.instance].material];
    Landing landing = Landing(vec3(0.0), -1.0);
    bool in_front = material.front == light.medium;
    if (in_front != (material.back == light.medium)) {
        vec3 normal = (in_front ? 1.0 : -1.0) * vertex.normal / max(length(vertex.normal), 1e-37);
        vec3 incident = light.kind == LIGHT_DIRECTIONAL ? light.direction : normalize(vertex.position - light.position);
        float eta = media[light.medium].index / media[in_front ? material.back : material.front].index;
        // Where the light is behind the vertex, or reflected totally, the limit of what is refracted near by.
        float cos_in = max(-dot(incident, normal), 0.0);
        float cos_out = sqrt(max(0.0, 1.0 - eta * eta * (1.0 - cos_in * cos_in)));
        vec3 along = incident + dot(-incident, normal) * normal;
        float size = length(along);
        float sine = sqrt(max(0.0, 1.0 - cos_out * cos_out));
        landing.direction = (size > 1e-12 ? along * (sine / size) : vec3(0.0)) - cos_out * normal;
        Hit hit = trace_closest(Ray(vertex.position, 0.0, landing.direction, push.far), MASK_DIFFUSE);
        landing.distance = hit.instance == NO_INSTANCE ? push.far : hit.t;
    }
    landings[at] = landing;
}
