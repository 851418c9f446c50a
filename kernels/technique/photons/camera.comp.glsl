// What the camera's view shows, for photons that land there and for the filter.
#include "technique/photons/store.glsl"

layout(push_constant) uniform CameraPush {
    uint camera;
    uint padding0;
    uint padding1;
    uint padding2;
} push;

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    uvec2 texel = uvec2(index % v.columns, index / v.columns);
    uvec2 ids = opaque_ids[id_index(v, texel)];
    CameraTexel seen = CameraTexel(0.0, 0u, 0u, NO_INSTANCE);
    if (ids.x > 0u) {
        Surface s = surface_shown(v, ids, chart_of(v, texel));
        vec3 from = s.position - v.origin;
        bool front = dot(from, s.geometric) < 0.0;
        seen = CameraTexel(dot(from, v.forward), pack_direction(front ? s.shading : -s.shading),
                           pack_direction(front ? s.geometric : -s.geometric), ids.x - 1u);
    }
    camera_texels[index] = seen;
}
