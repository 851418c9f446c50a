// Makes the leaves of each coarse cell add up to the light that goes through the cell (erratum 11), which is worked out by
// a quadrature of its own, fine enough for cones and images.
#include "technique/beams/common.glsl"
#include "technique/beams/leaf.glsl"
#include "technique/beams/ledger.glsl"

layout(push_constant) uniform CellsPush {
    vec2 jitter; // of the lattice, in coarse cells
    uint points; // of the quadrature along a side
    uint padding0;
} push;
layout(set = 3, binding = 14, std430) writeonly buffer CellFluxes { vec4 cell_fluxes[]; };

void main() {
    uint cell = linear_index();
    uint per_view = settings.grid * settings.grid;
    if (cell >= settings.views * per_view) return;
    LightView v = light_views[cell / per_view];
    uint place = cell % per_view;
    vec2 low = vec2(place % settings.grid, place / settings.grid);
    float side = float(1u << settings.levels);
    vec2 lower = lattice_chart(v, low * side, push.jitter);
    vec2 size = lattice_chart(v, (low + 1.0) * side, push.jitter) - lower;
    // Gauss-Legendre's two points in each of the parts along a side.
    vec3 flux = vec3(0.0);
    uint parts = push.points / 2u;
    for (uint k = 0u; k < push.points * push.points; k++) {
        uvec2 at = uvec2(k % push.points, k / push.points);
        vec2 inside = (vec2(at / 2u) + mix(vec2(0.21132486), vec2(0.78867513), vec2(at & 1u))) / float(parts);
        flux += light_power(v, lights[v.light], lower + inside * size);
    }
    flux *= size.x * size.y / float(push.points * push.points);
    // Compensated, for cells may have thousands of leaves.
    vec3 sum = vec3(0.0);
    vec3 lost = vec3(0.0);
    for (uint leaf = cell_leaves[cell]; leaf < min(cell_leaves[cell + 1u], settings.leaves); leaf++) {
        precise vec3 term = beam_leaves[leaf].power - lost;
        precise vec3 next = sum + term;
        lost = (next - sum) - term;
        sum = next;
    }
    cell_scales[cell] = vec4(mix(vec3(0.0), flux / max(sum, vec3(1e-37)), greaterThan(sum, vec3(0.0))), 0.0);
    cell_fluxes[cell] = vec4(flux, 0.0);
    book(LEDGER_EMITTED, flux, settings.ledger_unit);
}
