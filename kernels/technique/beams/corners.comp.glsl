// Makes the vertices of the coarse grid.
#include "technique/beams/common.glsl"

void main() {
    uint index = linear_index();
    uint side = settings.grid + 1u;
    if (index >= settings.views * side * side) return;
    uint rest = index % (side * side);
    make_vertex(index / (side * side), ivec2(rest % side, rest / side) << int(settings.levels));
}
