// Screen-space refraction, as real-time pictures have it (McGuire and Mara 2014, which the paper's section 4.1 leaves water to):
// what a pixel sees through the interface that is its first surface is looked up where its refracted ray meets what the
// camera's view shows of what is opaque, not at the visible point that the walk traced. One invocation a pixel.
#include "shared/meets.glsl"
#include "shared/visible.glsl"
#include "shared/round.glsl"
#include "technique/photons/march.glsl"
#include "technique/photons/store.glsl"
#include "technique/photons/tallies.glsl"

layout(set = 2, binding = 1, std430) readonly buffer PrimaryIds { uvec2 primary_ids[]; };
layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 3, binding = 4, std430) readonly buffer PhotonIrradiance { vec4 photon_irradiance[]; };
layout(push_constant) uniform RefractPush {
    uint camera;    // index of the camera's view
    uint max_steps;
    vec2 jitter;    // as in Sample
    uint listed;    // as in Sample
    uint linear;    // 1: marches texel by texel
    uint padding0;
    uint padding1;
} push;

// The texel that lies straight ahead.
uint texel_ahead(LightView v, vec3 direction) {
    vec4 at = place_of(v, direction);
    uvec2 texel = uvec2(clamp(at.xy / at.z, vec2(0.0), vec2(v.columns, v.rows) - 1.0));
    return texel.y * v.columns + texel.x;
}

// The texel that the place shows through the interface before it; NO_TEXEL where none is there, or where it reflects all.
uint texel_through(uint place) {
    RoundSample at = RoundSample(place, 0u, push.jitter);
    if (push.listed != 0u) at = round_samples[place];
    vec3 direction = normalize(pixel_direction(uvec2(at.pixel % view.width, at.pixel / view.width), at.jitter));
    uvec2 ids = primary_ids[place];
    vec2 barycentrics;
    if (ids.x == 0u || !meets(ids.x - 1u, ids.y, view.position, direction, barycentrics)) return NO_TEXEL;
    Surface s = surface_at(ids.x - 1u, ids.y, barycentrics);
    if (materials[s.material].kind != MATERIAL_DIELECTRIC) return NO_TEXEL;
    Interface i = interface_at(s, direction);
    if (i.reflectance >= 1.0) return NO_TEXEL;
    vec3 onward = refracted(i, direction);
    LightView camera = light_views[push.camera];
    MarchSettings how = MarchSettings(push.linear == 0u, false, false, push.max_steps);
    Trail trail = march(camera, push.camera, leave(s, onward), onward, 0.0, how);
    count(TALLY_REFRACTIONS, 1u);
    if (trail.end == TRAIL_HIT) return trail.texel.y * camera.columns + trail.texel.x;
    // What the view does not show: as if nothing were bent, which shows at borders least.
    count(TALLY_UNBENT, 1u);
    return texel_ahead(camera, direction);
}

void main() {
    open_tallies();
    barrier();
    uint place = linear_index();
    // Slots of the first layer come first.
    if (place < view.width * view.rows && visible_points[place].instance != NO_INSTANCE) {
        uint texel = texel_through(place);
        if (texel != NO_TEXEL) sample_irradiance[place] = vec4(photon_irradiance[texel].rgb, 0.0);
    }
    close_tallies();
}
