// How much surface stands for each texel of the camera's view that an edge runs through or beside, by rays through places
// spread over it: each place adds its surface to the texel that photons there go to.
#include "technique/photons/area.glsl"
#include "trace/interface.glsl"

layout(push_constant) uniform CoveragePush {
    StorePush store;
    uint places; // rays a texel
    uint padding0;
} push;

// Whether a texel or one beside it shows something else than the spot in its middle.
bool at_edge(LightView v, uvec2 texel, Spot middle, float width) {
    for (uint i = 0u; i < push.store.near; i++) {
        vec2 other = vec2(texel) + vec2(i % 3u, i / 3u) - 1.0;
        if (!inside_view(v, other)) continue;
        uvec2 at = uvec2(other);
        if (camera_texels[at.y * v.columns + at.x].instance != middle.instance) return true;
        if (middle.instance != NO_INSTANCE && !shows(v, at, middle, width)) return true;
    }
    return false;
}

void add_area(LightView v, uint texel, float area) {
    float part = area / (whole_area(v, texel) * float(push.places));
    atomicAdd(camera_areas[texel], uint(clamp(part / AREA_UNIT + 0.5, 0.0, 6.0e7)));
}

void main() {
    LightView v = light_views[push.store.camera];
    uint index = linear_index();
    if (index >= v.columns * v.rows) return;
    uvec2 texel = uvec2(index % v.columns, index / v.columns);
    CameraTexel own = camera_texels[index];
    vec2 chart = chart_of(v, texel);
    Spot middle = Spot(v.origin + own.depth * way_at(v, chart), own.instance, unpack_direction(own.geometric));
    if (!at_edge(v, texel, middle, texel_width(v, own.depth))) return;
    atomicOr(camera_areas[index], AREA_EDGE);
    vec2 step = (v.upper - v.lower) / vec2(v.columns - 1u, v.rows - 1u);
    for (uint k = 0u; k < push.places; k++) {
        // Hammersley's points: an edge along a row or a column is met by each of them apart.
        vec2 place = vec2((float(k) + 0.5) / float(push.places), float(bitfieldReverse(k)) / 4294967296.0);
        vec3 way = way_at(v, chart + (place - 0.5) * step);
        Hit hit = trace_closest(Ray(v.origin, 0.0, normalize(way), 1e30), MASK_DIFFUSE);
        float depth = NOTHING;
        uint found = NO_TEXEL;
        if (hit.instance != NO_INSTANCE) {
            Surface s = surface_at(hit.instance, hit.primitive, hit.barycentrics);
            vec3 geometric = dot(way, s.geometric) < 0.0 ? s.geometric : -s.geometric;
            depth = dot(s.position - v.origin, v.forward);
            vec4 at;
            found = texel_for(push.store, v, Spot(s.position, hit.instance, geometric), false, at);
            if (found != NO_TEXEL) add_area(v, found, area_over(v, way, geometric, depth));
        }
        if (found == index || own.instance == NO_INSTANCE) continue;
        // What goes on behind something else: photons land there too, and no view knows that they are hidden.
        float behind = dot(middle.geometric, middle.position - v.origin) / dot(middle.geometric, way);
        if (behind > depth && behind < NOTHING) add_area(v, index, area_over(v, way, middle.geometric, behind));
    }
}
