// What a view sees at each texel of one layer, as ids, and how far away the opaque layer is there: from the ids that
// light/visibility drew, or by rays alone.
#include "technique/photons/spaces.glsl"
#include "light/seen.glsl"

layout(set = 3, binding = 4, std430) readonly buffer LightIds { uvec2 light_ids[]; };
layout(set = 3, binding = 5, std430) writeonly buffer SpecularIds { uvec2 specular_ids[]; };
layout(push_constant) uniform SeePush {
    uint view;
    uint layer;
    uint rastered;   // 1: LightIds names triangles
    float thickness; // m that is taken to lie behind what is seen; 0: by the width of texels
} push;

// Slabs of surfaces at a glancing angle reach no farther than this many texels' widths.
const float STEEPEST = 32.0;
// Texels' widths that surfaces are thick where nobody says: what a ray can cross on its way over one.
const float THICKNESS = 1.0;

// Nearest and farthest depth of the surface over the texel, and what is taken to lie behind it.
vec2 slab_of(LightView v, uvec2 texel, uvec2 ids) {
    SeenPlane plane = plane_of(v, ids);
    vec2 half_step = 0.5 * (v.upper - v.lower) / vec2(v.columns - 1u, v.rows - 1u);
    vec2 at = chart_of(v, texel);
    float middle = plane_depth(v, plane, at);
    float width = texel_width(v, middle);
    float least = middle - STEEPEST * width;
    float most = middle + STEEPEST * width;
    vec2 slab = vec2(middle);
    for (uint corner = 0u; corner < 4u; corner++) {
        vec2 turn = vec2((corner & 1u) != 0u ? 1.0 : -1.0, (corner & 2u) != 0u ? 1.0 : -1.0);
        float depth = plane_depth(v, plane, at + turn * half_step);
        // Beyond the horizon the plane is behind the view, and infinitely deep before that.
        depth = depth > 0.0 ? clamp(depth, least, most) : most;
        slab = vec2(min(slab.x, depth), max(slab.y, depth));
    }
    slab.y += push.thickness > 0.0 ? push.thickness : THICKNESS * width;
    // What lies over the texel at its own middle is within, whatever rounding does.
    return vec2(max(slab.x - 1e-5 * middle, 0.0), slab.y + 1e-5 * middle);
}

void main() {
    LightView v = light_views[push.view];
    uint place = linear_index();
    if (place >= v.columns * v.rows) return;
    uvec2 texel = uvec2(place % v.columns, place / v.columns);
    vec3 origin, direction;
    light_ray(v, chart_of(v, texel), origin, direction);

    bool rastered = push.rastered != 0u;
    uvec2 drawn = uvec2(0u);
    if (rastered) drawn = light_ids[place];
    Seen seen = first_seen(rastered, drawn, push.layer, origin, direction);
    uvec2 ids = seen.instance == NO_INSTANCE ? uvec2(0u) : uvec2(seen.instance + 1u, seen.primitive);
    if (push.layer == LIGHT_SPECULAR) {
        specular_ids[v.first_texel + place] = ids;
        return;
    }
    opaque_ids[v.first_texel + place] = ids;
    vec2 slab = ids.x == 0u ? vec2(NOTHING) : slab_of(v, texel, ids);
    if (!(slab.x >= 0.0 && slab.y < NOTHING)) slab = vec2(NOTHING);
    depth_slabs[slab_index(v, push.view, 0u, texel)] = slab;
}
