// Whether further sweeps have anything to do: as many workgroups as they take, or none.
#include "shared/index.glsl"
#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform DecidePush {
    uint groups_x;
    uint groups_y;
} push;

void main() {
    if (linear_index() != 0u) return;
    bool more = checks.unsettled + checks.unreached > 0u;
    checks.groups[0] = more ? push.groups_x : 0u;
    checks.groups[1] = more ? push.groups_y : 0u;
    checks.groups[2] = more ? 1u : 0u;
    checks.groups[3] = 0u;
}
