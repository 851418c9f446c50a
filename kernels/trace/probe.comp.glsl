// Traces a list of rays; for tests, measurements and the choice of a back-end.

#include "trace/interface.glsl"
#include "shared/index.glsl"

struct ProbeHit {
    vec2 barycentrics;
    float t;
    uint instance;
    uint primitive;
    uint padding0;
};

layout(set = 2, binding = 0, std430) readonly buffer ProbeRays { Ray probe_rays[]; };
layout(set = 2, binding = 1, std430) writeonly buffer ProbeHits { ProbeHit probe_hits[]; };

layout(push_constant) uniform ProbePush {
    uint count;
    uint mask;
    uint any_hit; // 1: any hit will do
} probe;

void main() {
    uint i = linear_index();
    if (i >= probe.count) {
        return;
    }
    Hit hit = trace(probe_rays[i], probe.mask, probe.any_hit != 0u);
    probe_hits[i] = ProbeHit(hit.barycentrics, hit.t, hit.instance, hit.primitive, 0u);
}
