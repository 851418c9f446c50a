// The filter of irradiance on the camera's texels (Schied et al. 2017): what its kernels share. Every stop between two
// texels is the same from both sides, so that what one gains the other loses.
#include "technique/photons/area.glsl"

layout(push_constant) uniform DenoisePush {
    uint camera;    // index of the camera's view
    uint stride;    // texels between the wavelet's taps
    uint still;     // 1: the history lies on these very texels
    uint temporal;  // 1: there is a history
    uint adaptive;  // 1: it is shortened where light changes
    float alpha;    // share of a new set in a long history
    float change;   // standard deviations that light may differ from its history by
    float sigma;    // standard deviations that light may differ by between texels
    float normals;  // power of the cosine between normals
    float planes;   // texels' widths that a place may be off the other's plane
    uint padding0;
    uint padding1;
} push;

// What a texel shows, in world space.
struct Shown {
    vec3 position;
    vec3 shading;
    vec3 geometric;
    float width; // m across the texel
};

Shown shown_at(LightView v, CameraTexel seen, uvec2 texel) {
    vec2 at = chart_of(v, texel);
    return Shown(v.origin + seen.depth * (v.forward + at.x * v.right + at.y * v.up), unpack_direction(seen.shading),
                 unpack_direction(seen.geometric), texel_width(v, seen.depth));
}

// How much two texels belong together by where and how their surfaces lie.
float alike(Shown a, Shown b) {
    float cosine = max(dot(a.shading, b.shading), 0.0);
    vec3 apart = b.position - a.position;
    float off = max(abs(dot(apart, a.geometric)), abs(dot(apart, b.geometric)));
    return pow(cosine, push.normals) * exp(-off / (push.planes * max(a.width, b.width)));
}

float luminance(vec3 light) {
    return dot(light, vec3(0.2126, 0.7152, 0.0722));
}
