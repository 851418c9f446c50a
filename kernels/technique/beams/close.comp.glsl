// Makes the vertices of a stage that finer ones need: a triangle can be split only where it exists. Stages are closed
// from fine to coarse.
#include "technique/beams/stages.glsl"

bool needed(Middle m) {
    if (m.of_cell) {
        for (int side = 0; side < 4; side++) {
            ivec2 step = (side & 1) != 0 ? ivec2(0, m.half_side) : ivec2(m.half_side, 0);
            if (vertex_at(m.view, m.at + ((side & 2) != 0 ? step : -step)) != NO_VERTEX) return true;
        }
        return false;
    }
    int quarter = m.half_side / 2;
    if (quarter == 0) return false;
    for (int corner = 0; corner < 4; corner++) {
        ivec2 step = ivec2((corner & 1) != 0 ? quarter : -quarter, (corner & 2) != 0 ? quarter : -quarter);
        if (vertex_at(m.view, m.at + step) != NO_VERTEX) return true;
    }
    return false;
}

void main() {
    uint index = linear_index();
    if (index >= settings.views * stage_size()) return;
    Middle m = candidate(index);
    if (vertex_at(m.view, m.at) == NO_VERTEX && needed(m)) make_vertex(m.view, m.at);
}
