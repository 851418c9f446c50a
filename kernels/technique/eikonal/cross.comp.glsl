// Where each column of cells goes through the surface: one more in the cell from which on it is below, one less where it
// comes out. Sums of integers, so their order does not matter.
#include "technique/eikonal/surface.glsl"

// Twice the area of (from, to, at). The same product of the same numbers for both triangles of an edge, with the other sign.
float turn_of(vec2 from, vec2 to, vec2 at) {
    precise vec2 a = from - at;
    precise vec2 b = to - at;
    precise float first = a.x * b.y;
    precise float second = a.y * b.x;
    precise float turn = first - second;
    return turn;
}

// On an edge a column belongs to the triangle on one side of it.
bool inside_of(float turn, vec2 along) {
    if (turn != 0.0) return turn > 0.0;
    return along.y < 0.0 || (along.y == 0.0 && along.x > 0.0);
}

void main() {
    uint index = linear_index();
    if (index >= push.triangles * push.parts) return;
    EikonalVolume volume = volumes[push.volume];
    EikonalGrid grid = volume.grid;
    Facet f = facet_of(volume, index / push.parts);
    if (!f.valid || f.to_light.z == 0.0) return;
    vec3 a = f.cells[0];
    vec3 b = f.cells[1];
    vec3 c = f.cells[2];
    vec2 last = vec2(grid.cells.xy) - 1.0;
    ivec2 low = ivec2(max(ceil(min(min(a.xy, b.xy), c.xy)), vec2(0.0)));
    ivec2 high = ivec2(min(floor(max(max(a.xy, b.xy), c.xy)), last));
    float area = turn_of(a.xy, b.xy, c.xy);
    if (area == 0.0) return;
    if (area < 0.0) {
        vec3 swap = b;
        b = c;
        c = swap;
    }
    // Planes go away from the light, so a surface that faces it points against them.
    uint change = f.to_light.z < 0.0 ? 1u : 0xffffffffu;
    for (int v = low.y + int(index % push.parts); v <= high.y; v += int(push.parts)) {
        for (int u = low.x; u <= high.x; u++) {
            vec2 at = vec2(u, v);
            float wa = turn_of(b.xy, c.xy, at);
            float wb = turn_of(c.xy, a.xy, at);
            float wc = turn_of(a.xy, b.xy, at);
            if (!inside_of(wa, c.xy - b.xy) || !inside_of(wb, a.xy - c.xy) || !inside_of(wc, b.xy - a.xy)) continue;
            float height = (wa * a.z + wb * b.z + wc * c.z) / (wa + wb + wc);
            if (!(height <= float(grid.cells.z - 1u))) continue;
            int plane = int(ceil(max(height, 0.0)));
            atomicAdd(values[cell_index(grid, ivec3(u, v, plane))], change);
        }
    }
}
