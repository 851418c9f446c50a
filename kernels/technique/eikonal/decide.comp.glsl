// Whether further sweeps have anything to do: as many workgroups as a turn of them takes, or none.
#include "shared/index.glsl"
#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform DecidePush {
    uint groups_x;
    uint groups_y;
} push;

void main() {
    if (linear_index() != 0u) return;
    bool more = checks.asked > 0u;
    checks.groups_x = more ? push.groups_x : 0u;
    checks.groups_y = more ? push.groups_y : 0u;
    checks.groups_z = more ? 1u : 0u;
}
