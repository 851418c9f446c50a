// Sets the next indirect dispatch over vertices that are not traced yet.
#include "technique/beams/common.glsl"

void main() {
    if (linear_index() != 0u) return;
    uint last = min(state.vertices, settings.vertices);
    state.traced = state.waiting;
    state.waiting = last;
    uint groups = (last - state.traced + 63u) / 64u;
    state.groups_x = min(groups, 65535u);
    state.groups_y = (groups + 65534u) / 65535u;
    state.groups_z = 1u;
}
