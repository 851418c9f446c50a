// What a light sees at each point of its lattice, one invocation a texel of both layers: from the ids that
// light/visibility drew, or by rays alone.
#include "shared/index.glsl"
#include "light/seen.glsl"

layout(set = 3, binding = 0, std430) readonly buffer LightViews { LightView light_views[]; };
layout(set = 3, binding = 1, std430) writeonly buffer LightTexels { LightTexel light_texels[]; };
layout(set = 3, binding = 2, std430) readonly buffer LightIds { uvec2 light_ids[]; };
layout(push_constant) uniform LightViewPush {
    uint view;
    uint instance; // of light/visibility alone
    uint rastered; // 1: LightIds names triangles
    uint padding0;
} push;

void main() {
    LightView v = light_views[push.view];
    uint index = linear_index();
    uint texels = v.columns * v.rows;
    if (index >= texels * LIGHT_LAYERS) return;
    uint layer = index / texels;
    uint place = index % texels;
    vec2 at = chart_at(v, light_texel_place(v, uvec2(place % v.columns, place / v.columns)));
    vec3 origin, direction;
    light_ray(v, at, origin, direction);

    bool rastered = push.rastered != 0u;
    uvec2 drawn = uvec2(0u);
    if (rastered) drawn = light_ids[index];
    Seen seen = first_seen(rastered, drawn, layer, origin, direction);
    LightTexel texel = LightTexel(vec3(0.0), 0.0, 0u, 0u, 0u, NO_INSTANCE, vec2(0.0), 0u, 0u);
    if (seen.instance != NO_INSTANCE) {
        Surface s = surface_at(seen.instance, seen.primitive, seen.barycentrics);
        float depth = dot(s.position - origin, direction);
        texel = LightTexel(s.position, depth, pack_direction(s.shading), pack_direction(s.geometric), s.material,
                           seen.instance, seen.barycentrics, seen.primitive, 0u);
    }
    light_texels[v.first_texel + index] = texel;
}
