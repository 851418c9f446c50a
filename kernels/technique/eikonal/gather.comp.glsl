// Caustic irradiance at the visible points from one light's volume: what the volume has there, times the receiver's cosine and
// what the light sends to where the way back along the wave meets the surface. A ray goes that way, and on to the light: what is
// in between casts a shadow, and media take their part.
#include "shared/index.glsl"
#include "shared/media.glsl"
#include "shared/optics.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "trace/interface.glsl"
#include "technique/eikonal/volume.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { float values[]; };
layout(set = 3, binding = 6, std430) readonly buffer EikonalLights { float cell_lights[]; };

#include "technique/eikonal/look_up.glsl"

layout(push_constant) uniform LookUpPush {
    uint light;
    uint first;   // 1: nothing has been added up for this sample yet
    uint shadows; // 0: nothing but surfaces that refract is in the way
    uint factor;  // 1: the volume holds factors of what flat water would let through, not irradiance over what the light sends
    uint between; // 1: between cells
} push;

// Of what the light sends along its way at the surface, the part that is left where flat water of the surface's normal there
// would bring it: W/sr become W/m2.
float flat_light(EikonalVolume volume, Light light, Surface s, vec3 to_light, float above, float below) {
    float eta = media[volume.light_medium].index / media[volume.wave_medium].index;
    float cos_in = abs(dot(to_light, s.shading));
    float cos_out = sqrt(max(1.0 - eta * eta * (1.0 - cos_in * cos_in), 1e-4));
    float reach = above + eta * below;
    float spread = light.kind == LIGHT_DIRECTIONAL ? 1.0 : 1.0 / max(reach * reach, 1e-12);
    return spread * (1.0 - fresnel(cos_in, eta)) * cos_in / cos_out;
}

vec3 caustic_irradiance(VisiblePoint point) {
    EikonalVolume volume = volumes[0];
    if (point.instance == NO_INSTANCE || point.medium != volume.wave_medium) return vec3(0.0);
    LookUp found = look_up(volume.grid, point.position, push.between != 0u);
    float cosine = dot(-found.way, unpack_direction(point.normal));
    if (!(found.light > 0.0) || cosine <= 0.0 || dot(-found.way, unpack_direction(point.geometric)) <= 0.0) return vec3(0.0);

    Light light = lights[push.light];
    uint mask = push.shadows != 0u ? MASK_ALL : MASK_SPECULAR;
    vec3 irradiance = vec3(found.light * cosine);
    Ray ray = Ray(point.position, 0.0, -found.way, 1e30);
    for (uint segment = 0u; segment < 2u; segment++) {
        bool to_surface = segment == 0u;
        Hit hit = trace(ray, mask, !to_surface);
        if (!to_surface) return hit.instance == NO_INSTANCE ? irradiance : vec3(0.0);
        if (hit.instance == NO_INSTANCE) return vec3(0.0);
        Surface s = surface_at(hit.instance, hit.primitive, hit.barycentrics);
        Material material = materials[s.material];
        bool from_front = dot(ray.direction, s.geometric) < 0.0;
        uint beyond = from_front ? material.back : material.front;
        if (material.kind != MATERIAL_DIELECTRIC || beyond != volume.light_medium) return vec3(0.0);
        LightSample seen = light_at(light, s.position);
        irradiance *= light.kind == LIGHT_DIRECTIONAL ? seen.irradiance : light_power_along(light, -seen.to_light);
        if (push.factor != 0u) irradiance *= flat_light(volume, light, s, seen.to_light, seen.distance, hit.t);
        irradiance *= transmittance(volume.wave_medium, ray.origin, ray.direction, hit.t);
        ray = Ray(leave(s, seen.to_light), 0.0, seen.to_light, seen.distance);
        irradiance *= transmittance(volume.light_medium, ray.origin, ray.direction, ray.t_max);
    }
    return vec3(0.0);
}

void main() {
    uint slot = linear_index();
    if (slot >= view.width * view.rows * VISIBLE_LAYERS) return;
    vec3 before = push.first != 0u ? vec3(0.0) : sample_irradiance[slot].rgb;
    sample_irradiance[slot] = vec4(before + caustic_irradiance(visible_points[slot]), 0.0);
}
