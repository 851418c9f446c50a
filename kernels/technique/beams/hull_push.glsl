// What all stages of the drawing of hulls are told.
#include "technique/beams/shade_push.glsl"
#include "technique/beams/volume_push.glsl"

layout(push_constant) uniform HullPush {
    vec2 jitter;
    uint prism; // 1: prisms alone
    uint padding0;
    ShadePush shade;
    VolumePush volume;
} push;
