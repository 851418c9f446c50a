// The area of the surface that each slot's pixel covers, m2: what its irradiance counts for where light is spread over
// pixels. 0 where its neighbours do not tell; such a pixel keeps its light.
#include "shared/index.glsl"
#include "technique/beams/neighbours.glsl"
#include "technique/beams/footprint.glsl"

layout(set = 3, binding = 0, std430) writeonly buffer FilterAreas { float filter_areas[]; };

// The step to a neighbour that sees the same surface.
bool step_to(Site here, uint slot, out vec3 way) {
    Site other = site_at(slot);
    way = other.position - here.position;
    return on_one_surface(here, other, length(way));
}

float covered_area(uint slot) {
    Site here = site_at(slot);
    if (here.instance == NO_INSTANCE) return 0.0;
    uint place = slot % (view.width * view.rows);
    uint x = place % view.width;
    uint y = place / view.width;
    vec3 left = vec3(0.0), right = vec3(0.0), above = vec3(0.0), below = vec3(0.0);
    bool has_left = x > 0u && step_to(here, slot - 1u, left);
    bool has_right = x + 1u < view.width && step_to(here, slot + 1u, right);
    bool has_above = y > 0u && step_to(here, slot - view.width, above);
    bool has_below = y + 1u < view.rows && step_to(here, slot + view.width, below);
    vec3 across, down;
    if (!pixel_step(has_left, -left, has_right, right, across)) return 0.0;
    if (!pixel_step(has_above, -above, has_below, below, down)) return 0.0;
    return abs(dot(here.normal, cross(across, down)));
}

void main() {
    uint slot = linear_index();
    if (slot >= view.width * view.rows * VISIBLE_LAYERS) return;
    filter_areas[slot] = covered_area(slot);
}
