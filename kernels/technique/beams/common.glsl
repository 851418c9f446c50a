// Adaptive beam tracing (Liktor and Dachsbacher 2011): the lattice that beams are cut from, shared by the kernels that
// refine it and trace its vertices. renderer/technique/beams/generate.rs.
#include "shared/index.glsl"
#include "shared/math.glsl"
#include "shared/scene.glsl"
#include "shared/light_view.glsl"

// Plain numbers that stay for a set of beams.
struct BeamSettings {
    uint views;
    uint grid;     // cells of the coarse grid along a side of a view
    uint levels;   // times that a cell can be split in four
    uint sheets;   // kinds of paths, see vertex.glsl
    uint vertices; // room
    uint records;  // room
    uint leaves;   // room
    uint beams;    // room
    uint rules;    // bits of RULE_*
    uint least_level;   // cells are split this often, whatever the rules say
    float cos_normal;   // of the angle between normals that makes a discontinuity
    float depth;        // difference of two edges' lengths, over the shorter, that makes one
    float convergence;  // cross-section at the end over the one at the start below which light is focused
    float energy;       // of the flux of its coarse cell, what a beam has to carry to be split for focus or deviation
    float pixels;       // beams narrower than this are not split
    float deviation;    // pixels by which an edge's middle may land beside the mean of its ends
    float pattern;      // difference of the light's power at two corners, over the larger
    float cutoff;       // of the power at the light: weaker branches are not followed
    float reach;        // m: how far rays that meet nothing are followed
    float ledger_unit;  // W
    float extent;       // of the fluence at its start, below which an edge that meets nothing ends; 0: after `reach`
    uint margin;        // coarse cells by which the lattice is larger than the view, and can move
    uint buffered;      // 1: what the light sees is in the view's texels, which lie on the lattice; 0: it is traced
    uint corners;  // 3: compilers copy the body of a loop for each turn that they can count
};

const uint RULE_SURFACE = 1u;
const uint RULE_ENERGY = 2u;
const uint RULE_CAMERA = 4u;
const uint RULE_LIGHT = 8u;
const uint RULE_DEVIATION = 16u;

// What the stages of refinement hand on.
struct BeamState {
    uint groups_x; // of an indirect dispatch over the vertices that wait to be traced
    uint groups_y;
    uint groups_z;
    uint traced;   // vertices that have been
    uint vertices; // in use, and beyond the room for them what was asked for
    uint records;  // as above
    uint leaves;   // as above
    uint waiting;  // vertices up to which the dispatch goes
};

// A vertex of a lattice: columns and rows of its finest grid.
struct LatticePlace {
    uint view;
    uint column;
    uint row;
    uint hidden; // 1: something opaque, close before the specular surface, has the light's ray; see trace.comp.glsl
};

layout(set = 3, binding = 0, std430) readonly buffer BeamSettingsBlock { BeamSettings settings; };
layout(set = 3, binding = 1, std430) buffer BeamStates { BeamState state; };
// One more than the vertex's number, 0 where there is none.
layout(set = 3, binding = 2, std430) buffer LatticeMap { uint lattice_map[]; };
layout(set = 3, binding = 3, std430) buffer LatticePlaces { LatticePlace lattice_places[]; };
layout(set = 3, binding = 4, std430) readonly buffer LightViews { LightView light_views[]; };

// Columns of the finest grid, less one.
uint lattice_cells() {
    return settings.grid << settings.levels;
}

uint lattice_index(uint view, ivec2 at) {
    uint side = lattice_cells() + 1u;
    return (view * side + uint(at.y)) * side + uint(at.x);
}

bool on_lattice(ivec2 at) {
    int last = int(lattice_cells());
    return at.x >= 0 && at.y >= 0 && at.x <= last && at.y <= last;
}

// The number of the vertex there, NO_VERTEX where there is none.
const uint NO_VERTEX = 0xffffffffu;

uint vertex_at(uint view, ivec2 at) {
    return on_lattice(at) ? lattice_map[lattice_index(view, at)] - 1u : NO_VERTEX;
}

// Makes a vertex; each place is asked for by one invocation alone.
void make_vertex(uint view, ivec2 at) {
    uint number = atomicAdd(state.vertices, 1u);
    if (number >= settings.vertices) return;
    lattice_map[lattice_index(view, at)] = number + 1u;
    lattice_places[number] = LatticePlace(view, uint(at.x), uint(at.y), 0u);
}

// Of the lattice, in the chart.
vec2 coarse_cell(LightView v) {
    return (v.upper - v.lower) / float(settings.grid - settings.margin);
}

// Where a place on the lattice, which jitter may have moved, is drawn in to: the border of the view's rectangle for what lies
// beyond it, since the next face of a cube sees that.
vec2 drawn_in(vec2 at, vec2 jitter) {
    float side = float(1u << settings.levels);
    return clamp(at, jitter * side, (jitter + float(settings.grid - settings.margin)) * side);
}

// The chart's coordinates of a place on the lattice.
vec2 lattice_chart(LightView v, vec2 at, vec2 jitter) {
    vec2 cell = coarse_cell(v);
    return v.lower - jitter * cell + drawn_in(at, jitter) / float(1u << settings.levels) * cell;
}
