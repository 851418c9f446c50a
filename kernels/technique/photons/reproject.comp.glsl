// The history as it lies on this frame's texels (Schied et al. 2017, section 4.1): each texel's place is followed back to
// where the camera before saw it, and of the four texels around those count that showed the same surface.
#include "technique/photons/denoise.glsl"

layout(set = 3, binding = 10, std430) readonly buffer PhotonHistory { vec4 photon_history[]; };  // irradiance, sets
layout(set = 3, binding = 11, std430) readonly buffer PhotonMoments { vec4 photon_moments[]; };
layout(set = 3, binding = 12, std430) writeonly buffer FollowedHistory { vec4 followed_history[]; };
layout(set = 3, binding = 13, std430) writeonly buffer FollowedMoments { vec4 followed_moments[]; };
layout(set = 3, binding = 14, std430) readonly buffer TexelsBefore { CameraTexel texels_before[]; };
layout(set = 3, binding = 15, std430) readonly buffer ViewBefore { LightView view_before; };
// Rows of the map from where a point of an instance is to where it was.
layout(set = 3, binding = 16, std430) readonly buffer WaysBack { vec4 ways_back[]; };

// Between the normals of a surface and of itself before.
const float SAME_NORMAL = 0.9;
// Texels' widths that a place before may be off the plane that the surface then had.
const float SAME_PLANE = 1.0;
// Of a texel: nearer to a texel's middle its history is taken as it is, so that rounding does not blur it.
const float SAME_PLACE = 1e-3;
// Of the four texels' weights, below which too little of the surface was seen.
const float LEAST_WEIGHT = 0.01;

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    if (push.still != 0u) {
        followed_history[index] = photon_history[index];
        followed_moments[index] = photon_moments[index];
        return;
    }
    vec4 history = vec4(0.0);
    vec4 moments = vec4(0.0);
    float sum = 0.0;
    CameraTexel seen = camera_texels[index];
    if (seen.instance != NO_INSTANCE) {
        Shown now = shown_at(v, seen, uvec2(index % v.columns, index / v.columns));
        vec4 back[3];
        for (uint row = 0u; row < 3u; row++) back[row] = ways_back[3u * seen.instance + row];
        vec3 position = transform_point(back, now.position);
        vec3 shading = normalize(transform_vector(back, now.shading));
        vec3 geometric = normalize(transform_vector(back, now.geometric));
        LightView before = view_before;
        vec4 at = place_of(before, position - before.origin);
        vec2 place = at.w > NEAREST ? at.xy / at.z - 0.5 : vec2(-2.0);
        vec2 middle = floor(place + 0.5);
        if (all(lessThan(abs(place - middle), vec2(SAME_PLACE)))) place = middle;
        vec2 low = floor(place);
        vec2 part = place - low;
        for (int i = 0; i < 4; i++) {
            vec2 corner = vec2(i & 1, i >> 1);
            vec2 texel = low + corner;
            vec2 share = mix(1.0 - part, part, corner);
            float weight = share.x * share.y;
            bool outside = any(lessThan(texel, vec2(0.0))) || any(greaterThanEqual(texel, vec2(before.columns, before.rows)));
            if (outside || weight <= 0.0) continue;
            uvec2 t = uvec2(texel);
            uint from = t.y * before.columns + t.x;
            CameraTexel was = texels_before[from];
            if (was.instance != seen.instance) continue;
            Shown then = shown_at(before, was, t);
            if (dot(then.shading, shading) < SAME_NORMAL) continue;
            if (abs(dot(then.position - position, geometric)) > SAME_PLANE * then.width) continue;
            history += weight * photon_history[from];
            moments += weight * photon_moments[from];
            sum += weight;
        }
    }
    bool found = sum > LEAST_WEIGHT;
    followed_history[index] = found ? history / sum : vec4(0.0);
    followed_moments[index] = found ? moments / sum : vec4(0.0);
}
