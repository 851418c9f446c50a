// From flux to irradiance, over the area of surface that each texel of the camera's view covers (erratum 12).
#include "technique/photons/area.glsl"

layout(set = 3, binding = 4, std430) writeonly buffer PhotonIrradiance { vec4 photon_irradiance[]; };
layout(push_constant) uniform IrradiancePush {
    uint camera;
    float flux_unit;   // W
    uint printed_area; // 1: Eq. 3 of the paper
    uint padding0;
} push;

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    vec3 units = vec3(photon_flux[3u * index], photon_flux[3u * index + 1u], photon_flux[3u * index + 2u]);
    CameraTexel seen = camera_texels[index];
    vec3 irradiance = vec3(0.0);
    if (seen.instance != NO_INSTANCE) {
        float area = texel_area(v, index);
        if (push.printed_area != 0u) {
            vec3 way = way_at(v, chart_of(v, uvec2(index % v.columns, index / v.columns)));
            area = plane_area(v, seen.depth) * dot(way, way);
        }
        irradiance = units * (push.flux_unit / area);
    }
    photon_irradiance[index] = vec4(irradiance, 0.0);
}
