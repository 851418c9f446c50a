// Goes over the cells that light through a triangle can reach next to the surface.

// Whether anything is to be done with a cell.
bool wanted(int cell);

// What is done with a cell whose middle is `to`; no path to it through the facet is shorter than `bound`.
void meet(EikonalVolume volume, Facet f, int cell, vec3 to, float bound);

// Cells beside where light through a triangle's plane goes that are looked at too: what edges and corners spread, by up to a
// quarter of a radian.
const float MARGIN = 0.5;
// Facets steeper than this against the planes are looked at all round.
const float STEEP = 0.4;
// Of a path in metres, what rounding may make of a bound.
const float SLACK = 1e-5;

// How far light through the facet goes along u and v from plane to plane.
vec2 drift_of(EikonalVolume volume, Facet f, vec3 middle) {
    vec3 way = way_at(volume.source, middle);
    vec3 across = way - f.normal * dot(way, f.normal);
    float index = volume.grid.index;
    float ahead = sqrt(max(index * index - dot(across, across), 1e-4));
    vec3 refracted = turn_to_cells(volume.grid, across) - ahead * f.to_light;
    return refracted.z > 1e-3 ? clamp(refracted.xy / refracted.z, -3.0, 3.0) : vec2(0.0);
}

void main() {
    uint index = linear_index();
    if (index >= push.triangles * push.parts) return;
    EikonalVolume volume = volumes[push.volume];
    EikonalGrid grid = volume.grid;
    Facet f = facet_of(volume, index / push.parts);
    if (!f.valid) return;
    vec3 middle = (f.corner[0] + f.corner[1] + f.corner[2]) / 3.0;
    float path_here = path_to(volume.source, middle);
    vec3 way_here = way_at(volume.source, middle);
    // Light, and the paper's wave, come in only from the light's side.
    vec3 coming = volume.source.kind == SOURCE_SURFACE ? vec3(0.0, 0.0, 1.0) : turn_to_cells(grid, way_here);
    if (dot(coming, f.to_light) >= 0.0) return;

    vec3 lower = min(min(f.cells[0], f.cells[1]), f.cells[2]);
    vec3 upper = max(max(f.cells[0], f.cells[1]), f.cells[2]);
    float reach = float(volume.band) + 0.25;
    vec2 last = vec2(grid.cells.xy) - 1.0;
    if (any(lessThan(upper.xy, vec2(-3.0 * reach - MARGIN))) || any(greaterThan(lower.xy, last + 3.0 * reach + MARGIN))) return;
    float bulge = 2.0 * volume.grid.index * most_bulge(f);
    bool steep = abs(f.to_light.z) < STEEP;
    vec2 drift = steep ? vec2(0.0) : drift_of(volume, f, middle) * reach;
    vec2 around = vec2(steep ? reach + 1.0 : MARGIN);
    ivec2 low = ivec2(clamp(ceil(lower.xy + min(drift, vec2(0.0)) - around), vec2(0.0), last + 1.0));
    ivec2 high = ivec2(clamp(floor(upper.xy + max(drift, vec2(0.0)) + around), vec2(-1.0), last));
    // Heights of the facet's plane over the columns, which say what planes are near.
    vec2 slope = steep ? vec2(0.0) : -f.to_light.xy / f.to_light.z;
    float sideways = dot(abs(slope), abs(drift) + around);
    for (int v = low.y + int(index % push.parts); v <= high.y; v += int(push.parts)) {
        for (int u = low.x; u <= high.x; u++) {
            float height = f.cells[0].z + dot(slope, vec2(u, v) - f.cells[0].xy);
            vec2 near = steep ? vec2(lower.z, upper.z) : clamp(vec2(height - sideways, height + sideways), lower.z, upper.z);
            int first = int(max(ceil(near.x), 0.0)) - (steep ? int(reach) + 1 : 0);
            int end = int(min(floor(near.y + reach + 1.0), float(grid.cells.z - 1u)));
            for (int p = max(first, 0); p <= end; p++) {
                ivec3 at = ivec3(u, v, p);
                int cell = cell_index(grid, at);
                if (!wanted(cell)) continue;
                vec3 to = to_world(grid, vec3(at));
                // The path is convex over the facet, so it lies above its tangent at the middle.
                vec3 away = middle - to;
                float far = length(away);
                vec3 rise = way_here + grid.index * away / max(far, 1e-20);
                float bound = path_here + grid.index * far;
                bound += min(min(dot(rise, f.corner[0] - middle), dot(rise, f.corner[1] - middle)), dot(rise, f.corner[2] - middle));
                meet(volume, f, cell, to, bound - bulge - SLACK * (abs(bound) + far));
            }
        }
    }
}
