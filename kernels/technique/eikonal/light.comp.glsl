// Light along the wave (erratum 16) without steps along it: light in one medium is straight, so that phi and its gradient in a
// cell say where on the surface its light comes from, and in which direction that left the light. Between four neighbours
// of a plane goes the light that left between their four directions. Nothing is blurred on the way, and all light that
// passes a plane is there: where waves have met, what lies between the two sides' directions is in the quad between them.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "technique/eikonal/volume.glsl"
#include "shared/optics.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { float values[]; };
// Of the quad from a cell to the next along u and v: its middle is half a cell further along both.
layout(set = 3, binding = 6, std430) writeonly buffer EikonalLights { float cell_lights[]; };

#include "technique/eikonal/slopes.glsl"

layout(push_constant) uniform LitPush {
    uint volume;
    uint runs; // of a row of cells
} push;

// Quads that an invocation goes through, so that corners are worked out about twice instead of four times.
const uint RUN = 8u;
// The function is nearly straight: what is left is squared in each.
const int NEWTON_STEPS = 3;

// Where light comes from that passes a cell's middle.
struct Origin {
    vec3 place;   // direction from a point light; else where on the surface, m, of which only differences are used
    float passed; // by the surface
    float ahead;  // of the unit way, from plane to plane
    bool known;
};

// Metres back along the unit way to where light crossed the surface.
float way_back(EikonalSource source, vec3 to, vec3 way, float value, float below) {
    if (source.kind == SOURCE_SURFACE) return value / below;
    int steps = source.kind == SOURCE_POINT ? NEWTON_STEPS : 1;
    float back = 0.0;
    for (int i = 0; i < steps; i++) {
        vec3 at = to - back * way;
        float slope = below - dot(way_at(source, at), way);
        if (abs(slope) < 1e-3) break;
        back -= (path_to(source, at) + below * back - value) / slope;
    }
    return max(back, 0.0);
}

Origin origin_of(EikonalVolume volume, ivec3 at) {
    Origin origin = Origin(vec3(0.0), 0.0, 0.0, false);
    EikonalGrid grid = volume.grid;
    EikonalSource source = volume.source;
    float value = wave_at(grid, at);
    if (!(value < UNKNOWN)) return origin;
    vec3 rise = rise_at_cell(grid, at, value);
    float steep = length(rise);
    if (!(steep > 0.0)) return origin;
    vec3 way = turn_to_world(grid, rise / steep);
    vec3 to = to_world(grid, vec3(at));
    vec3 from = to - way_back(source, to, way, value, grid.index) * way;
    vec3 light_way = way_at(source, from);
    origin.known = true;
    origin.ahead = rise.z / steep;
    origin.place = source.kind == SOURCE_POINT ? light_way / source.index : from - source.reference;
    // Snell's law: the normal is along the change of index times direction.
    vec3 normal = grid.index * way - light_way;
    float size = length(normal);
    float cos_in = size > 0.0 ? abs(dot(normal, light_way)) / (size * max(source.index, 1e-20)) : 1.0;
    origin.passed = source.kind == SOURCE_SURFACE ? 1.0 : 1.0 - fresnel(min(cos_in, 1.0), source.index / grid.index);
    return origin;
}

// Irradiance across the light's way over what the light sends, from the corners in turn: over W/sr in 1/m2, over W/m2 a number.
// UNLIT where it is not known.
float light_between(EikonalVolume volume, Origin a, Origin b, Origin c, Origin d) {
    if (!(a.known && b.known && c.known && d.known)) return UNLIT;
    vec3 area = 0.5 * cross(c.place - a.place, d.place - b.place);
    vec3 across = volume.source.kind == SOURCE_POINT ? a.place + b.place + c.place + d.place : volume.source.place;
    if (volume.source.kind == SOURCE_SURFACE) across = turn_to_world(volume.grid, vec3(0.0, 0.0, 1.0));
    float sent = abs(dot(area, across)) / max(length(across), 1e-20);
    float passed = 0.25 * (a.passed + b.passed + c.passed + d.passed);
    float ahead = 0.25 * (a.ahead + b.ahead + c.ahead + d.ahead);
    float light = sent * passed / (volume.grid.cell * volume.grid.cell * max(ahead, 0.05));
    return all_finite(vec3(light)) ? light : UNLIT;
}

void main() {
    EikonalVolume volume = volumes[push.volume];
    uvec3 cells = volume.grid.cells;
    uint index = linear_index();
    uint row = index / push.runs;
    if (row >= cells.y * cells.z) return;
    ivec3 at = ivec3((index - row * push.runs) * RUN, row % cells.y, row / cells.y);
    int end = min(at.x + int(RUN), int(cells.x));
    Origin a = origin_of(volume, at);
    Origin d = origin_of(volume, at + ivec3(0, 1, 0));
    for (; at.x < end; at.x++) {
        Origin b = origin_of(volume, at + ivec3(1, 0, 0));
        Origin c = origin_of(volume, at + ivec3(1, 1, 0));
        cell_lights[cell_index(volume.grid, at)] = light_between(volume, a, b, c, d);
        a = b;
        d = c;
    }
}
