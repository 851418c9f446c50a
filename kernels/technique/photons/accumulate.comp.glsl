// Adds a set to the history, and estimates the variance of what comes of it (Schied et al. 2017, sections 4.1 and 4.2).
#include "technique/photons/denoise.glsl"

layout(set = 3, binding = 4, std430) readonly buffer PhotonIrradiance { vec4 photon_irradiance[]; };
layout(set = 3, binding = 10, std430) writeonly buffer PhotonHistory { vec4 photon_history[]; }; // irradiance, sets
// Of a set's luminance: mean, mean square. Then, of the history, the sum of squares of the sets' shares.
layout(set = 3, binding = 11, std430) writeonly buffer PhotonMoments { vec4 photon_moments[]; };
layout(set = 3, binding = 12, std430) readonly buffer FollowedHistory { vec4 followed_history[]; };
layout(set = 3, binding = 13, std430) readonly buffer FollowedMoments { vec4 followed_moments[]; };
layout(set = 3, binding = 17, std430) writeonly buffer FilterTo { vec4 filter_to[]; };           // irradiance, variance

// Texels to each side that a set's own variance is estimated over.
const int REACH = 3;
// Sets below which a history cannot tell the variance.
const float FEW_SETS = 4.0;
// Of light, differences that are no change whatever the noise.
const float LEAST_CHANGE = 0.05;
// Sets, so that counting on does no harm.
const float MOST_SETS = 65536.0;

// Sums over a window: of this set against the history, where there is one.
struct Window {
    float weight;
    float squares; // of weights
    vec2 set;      // luminance, its square
    float light;   // of the history, followed
    vec4 moments;  // of the history; the last: squares of its mean
};

Window wider(Window w, float weight, float set, float light, vec4 moments) {
    moments.w = moments.x * moments.x;
    return Window(w.weight + weight, w.squares + weight * weight, w.set + weight * vec2(set, set * set),
                  w.light + weight * light, w.moments + weight * moments);
}

// By how many standard deviations the set's mean over a window differs from its history's.
float difference(Window w) {
    if (w.weight <= 0.0) return 0.0;
    float count = w.weight * w.weight / w.squares;
    vec2 set = w.set / w.weight;
    float light = w.light / w.weight;
    vec4 moments = w.moments / w.weight;
    // Of a set as it was: from set to set and, where those are few, from texel to texel.
    bool few = moments.z * FEW_SETS > 1.0;
    float was = few ? moments.y - moments.x * moments.x : (moments.y - moments.w) / (1.0 - moments.z);
    // As it is now or as it was, whichever is more: what was dark, or is, knows no variance.
    float variance = max(max(set.y - set.x * set.x, was), 0.0);
    float deviation = sqrt(variance * (1.0 + moments.z) / count);
    return abs(set.x - light) / max(max(deviation, LEAST_CHANGE * max(set.x, light)), 1e-30);
}

void main() {
    LightView v = light_views[push.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    ivec2 texel = ivec2(index % v.columns, index / v.columns);
    CameraTexel seen = camera_texels[index];
    vec4 light = vec4(0.0);
    vec4 moments = vec4(0.0);
    float variance = 0.0;
    if (seen.instance != NO_INSTANCE) {
        Shown here = shown_at(v, seen, uvec2(texel));
        float weights = 0.0;
        float first = 0.0;
        float second = 0.0;
        Window near = Window(0.0, 0.0, vec2(0.0), 0.0, vec4(0.0));
        Window wide = near;
        for (int i = 0; i < (2 * REACH + 1) * (2 * REACH + 1); i++) {
            ivec2 step = ivec2(i % (2 * REACH + 1), i / (2 * REACH + 1)) - REACH;
            ivec2 at = texel + step;
            if (any(lessThan(at, ivec2(0))) || any(greaterThanEqual(at, ivec2(v.columns, v.rows)))) continue;
            uint tap = uint(at.y) * v.columns + uint(at.x);
            CameraTexel other = camera_texels[tap];
            if (other.instance == NO_INSTANCE) continue;
            float weight = alike(here, shown_at(v, other, uvec2(at)));
            float own = luminance(photon_irradiance[tap].rgb);
            weights += weight;
            first += weight * own;
            second += weight * own * own;
            if (push.temporal == 0u || push.adaptive == 0u) continue;
            vec4 history = followed_history[tap];
            if (history.w <= 0.0) continue;
            wide = wider(wide, weight, own, luminance(history.rgb), followed_moments[tap]);
            if (max(abs(step.x), abs(step.y)) <= 1) {
                near = wider(near, weight, own, luminance(history.rgb), followed_moments[tap]);
            }
        }
        float mean = first / weights;
        float spatial = max(second / weights - mean * mean, 0.0);

        vec3 set = photon_irradiance[index].rgb;
        float own = luminance(set);
        vec4 history = vec4(0.0);
        vec4 before = vec4(0.0);
        if (push.temporal != 0u) {
            history = followed_history[index];
            before = followed_moments[index];
        }
        if (push.adaptive != 0u) {
            float beyond = max(difference(near), difference(wide)) / push.change - 1.0;
            history.w *= 1.0 - clamp(2.0 * beyond, 0.0, 1.0);
        }
        float share = max(1.0 / (history.w + 1.0), push.alpha);
        light = vec4(mix(history.rgb, set, share), min(history.w + 1.0, MOST_SETS));
        moments.xy = mix(before.xy, vec2(own, own * own), share);
        moments.z = (1.0 - share) * (1.0 - share) * before.z + share * share;
        float temporal = max(moments.y - moments.x * moments.x, 0.0) / max(1.0 - moments.z, 1e-3);
        variance = moments.z * (light.w < FEW_SETS ? spatial : temporal);
    }
    if (push.temporal != 0u) {
        photon_history[index] = light;
        photon_moments[index] = moments;
    }
    filter_to[index] = vec4(light.rgb, variance);
}
