// Spreads irradiance over the pixels of a row or a column that see the same surface. Any two of them exchange light by
// their difference, for the smaller of their areas: what one loses the other gains, what is even stays as it is, and a
// neighbour that is missing leaves its share where it was.
#include "shared/index.glsl"
#include "technique/beams/neighbours.glsl"

layout(set = 3, binding = 0, std430) readonly buffer FilterAreas { float filter_areas[]; };
layout(set = 3, binding = 1, std430) readonly buffer FilterFrom { vec4 filter_from[]; };
layout(set = 3, binding = 2, std430) writeonly buffer FilterTo { vec4 filter_to[]; };
layout(push_constant) uniform FilterPush {
    uint down;     // 1: along columns, 0: along rows
    uint radius;   // pixels
    float falloff; // 1 / (2 sigma^2), 1/pixels^2
    float share;   // one over the sum of all weights
} push;

// What comes in from up to `count` pixels one way, times the slot's area.
vec3 from_side(uint slot, int step, uint count, Site here, float area, vec3 own) {
    vec3 sum = vec3(0.0);
    Site last = here;
    float last_area = area;
    for (uint k = 1u; k <= count; k++) {
        uint other = uint(int(slot) + int(k) * step);
        Site next = site_at(other);
        float next_area = filter_areas[other];
        // Beyond what stands between, the same surface may be in another light.
        if (next_area <= 0.0 || !on_one_surface(last, next, sqrt(min(last_area, next_area)))) break;
        last = next;
        last_area = next_area;
        float common_area = min(area, next_area);
        if (!on_one_surface(here, next, sqrt(common_area))) continue;
        float weight = exp(-float(k * k) * push.falloff);
        sum += weight * common_area * (filter_from[other].rgb - own);
    }
    return sum;
}

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    vec3 own = filter_from[slot].rgb;
    float area = filter_areas[slot];
    if (area > 0.0) {
        uint place = slot % pixels;
        uint at = push.down != 0u ? place / view.width : place % view.width;
        uint last = (push.down != 0u ? view.rows : view.width) - 1u;
        int step = push.down != 0u ? int(view.width) : 1;
        Site here = site_at(slot);
        vec3 sum = from_side(slot, -step, min(push.radius, at), here, area, own) +
                   from_side(slot, step, min(push.radius, last - at), here, area, own);
        own += push.share / area * sum;
    }
    filter_to[slot] = vec4(own, 0.0);
}
