// When the wave comes in to which cells, how strong, and what there is of it at first: a tile of a block an invocation.
// Cells that are given know the optical path to them, so that the wave in them is known at all times. Beyond the sides of the
// volume it comes in as the eikonal solution goes on there.
#include "shared/index.glsl"
#include "technique/eikonal/wave.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 3, std430) readonly buffer EikonalTops { int tops[]; }; // each column's first plane inside
layout(set = 3, binding = 6, std430) readonly buffer EikonalLights { float lights[]; };
layout(set = 3, binding = 7, std430) writeonly buffer WaveNow { float now[]; };
layout(set = 3, binding = 9, std430) writeonly buffer WaveSums { float sums[]; };
layout(set = 3, binding = 10, std430) writeonly buffer WaveArrivals { float arrivals[]; };
layout(set = 3, binding = 11, std430) writeonly buffer WaveAmplitudes { float amplitudes[]; };
layout(set = 3, binding = 12, std430) buffer WaveBlocks { WaveBlock wave_blocks[]; };
layout(push_constant) uniform WaveStartPush {
    WaveGrid grid;
    float step;   // refractive index times m, a cell
    float lead;   // cells: the time at which the wave is at path 0
    float scale;  // light for which the amplitude is 1
    float at_once; // above 0: the wave is 1 in the surface's cells at first, which are left with this sum, and goes on from there
} push;

struct Arrival {
    float time;      // cells; negative where the wave is given at all times; FREE; OUTSIDE
    float amplitude;
};

const Arrival NONE = Arrival(FREE, 0.0);

// Light just below the surface by a cell, from the quads of cells around it; looked for deeper where the surface cuts them.
float light_by(ivec3 at) {
    ivec3 size = ivec3(push.grid.cells);
    for (int deeper = 0; deeper <= 2; deeper++) {
        vec2 sum = vec2(0.0);
        for (int i = 0; i < 4; i++) {
            ivec3 quad = at + ivec3(-(i & 1), -(i >> 1), deeper);
            bool there = all(greaterThanEqual(quad, ivec3(0))) && all(lessThan(quad, size));
            float light = there ? lights[volume_index(push.grid, quad)] : UNLIT;
            if (light >= 0.0) sum += vec2(light, 1.0);
        }
        if (sum.y > 0.0) return sum.x / sum.y;
    }
    return 0.0;
}

float known_at(ivec3 at) {
    return uintBitsToFloat(values[volume_index(push.grid, at)]);
}

bool air_at(ivec3 at) {
    ivec3 last = ivec3(push.grid.cells) - 1;
    return at.z < 0 || known_at(clamp(at, ivec3(0), last)) == OUTSIDE;
}

// Of the path, what it grows by from a side outwards; 0 where that is not known.
float rise(ivec3 at, ivec3 outwards) {
    ivec3 inner = at - outwards;
    if (any(lessThan(inner, ivec3(0))) || any(greaterThanEqual(inner, ivec3(push.grid.cells)))) return 0.0;
    float here = abs(known_at(at));
    float before = abs(known_at(inner));
    return here < UNKNOWN && before < UNKNOWN ? here - before : 0.0;
}

bool is_given(ivec3 at) {
    return (values[volume_index(push.grid, at)] & GIVEN) != 0u;
}

// Whether the water's surface passes by a cell.
bool at_surface(ivec3 at) {
    if (air_at(at)) return false;
    return air_at(at - ivec3(0, 0, 1)) || air_at(at - ivec3(1, 0, 0)) || air_at(at + ivec3(1, 0, 0)) ||
           air_at(at - ivec3(0, 1, 0)) || air_at(at + ivec3(0, 1, 0));
}

Arrival arrival_at(ivec3 at) {
    ivec3 last = ivec3(push.grid.cells) - 1;
    ivec3 inner = clamp(at, ivec3(0), last);
    ivec3 beyond = at - inner;
    int cell = volume_index(push.grid, inner);
    uint known = values[cell];
    float value = uintBitsToFloat(known);
    if (value == OUTSIDE) return Arrival(OUTSIDE, 0.0);
    bool given = (known & GIVEN) != 0u;
    if (!given && beyond.xy == ivec2(0)) return NONE;
    value = abs(value);
    if (value >= UNKNOWN) return NONE;
    if (beyond.x != 0) value += float(abs(beyond.x)) * rise(inner, ivec3(sign(beyond.x), 0, 0));
    if (beyond.y != 0) value += float(abs(beyond.y)) * rise(inner, ivec3(0, sign(beyond.y), 0));
    if (beyond.z != 0) value += float(abs(beyond.z)) * rise(inner, ivec3(0, 0, sign(beyond.z)));
    // Where the border ends there is no neighbour to step a cell by, and what comes in is all there is.
    bool end = max(abs(beyond.x), abs(beyond.y)) >= int(push.grid.border);
    float time = max(value / push.step + push.lead, 0.5);
    // By the sides comes what no focus inside has gathered.
    ivec3 lit = beyond == ivec3(0) ? inner : ivec3(inner.xy, min(tops[uint(inner.y) * push.grid.cells.x + uint(inner.x)], last.z));
    return Arrival(given || end ? -time : time, sqrt(light_by(lit) / push.scale));
}

// Has a block and those around it stepped at first.
void let_go(ivec3 block) {
    ivec3 blocks = ivec3(push.grid.blocks);
    ivec3 low = max(block - 1, ivec3(0));
    ivec3 high = min(block + 1, blocks - 1);
    for (int z = low.z; z <= high.z; z++) {
        for (int y = low.y; y <= high.y; y++) {
            for (int x = low.x; x <= high.x; x++) atomicMax(wave_blocks[(z * blocks.y + y) * blocks.x + x].first, ~0u);
        }
    }
}

void main() {
    uint index = linear_index();
    uint group = index / TILES;
    WaveGrid grid = push.grid;
    uint columns = grid.blocks.x * grid.blocks.y;
    if (group >= columns * grid.blocks.z) return;
    uvec3 block = uvec3(group % grid.blocks.x, group % columns / grid.blocks.x, group / columns);
    ivec3 place = tile_place(block, index % TILES);
    ivec3 size = ivec3(grid.cells);
    bool driven = false;
    bool surface = false;
    float first = FREE;
    float last = 0.0;
    for (int i = 0; i < TILE.x * TILE.y * WAVE_BLOCK.z; i++) {
        ivec3 at = place + ivec3(i % TILE.x, i / TILE.x % TILE.y, i / (TILE.x * TILE.y));
        ivec3 cell = volume_place(grid, at);
        bool inside = all(greaterThanEqual(cell, ivec3(0))) && all(lessThan(cell, size));
        Arrival found = NONE;
        int cell_of_wave = wave_index(grid, at);
        if (push.at_once == 0.0) found = arrival_at(cell);
        else if (inside && is_given(cell)) found.amplitude = sqrt(light_by(cell) / push.scale);
        if (push.at_once != 0.0 && at_surface(cell)) {
            now[cell_of_wave] = 1.0;
            sums[cell_of_wave] = push.at_once;
            surface = true;
        }
        arrivals[cell_of_wave] = found.time;
        amplitudes[cell_of_wave] = found.amplitude;
        driven = driven || !inside || found.time != FREE;
        if (found.amplitude > 0.0 && found.time != FREE) {
            first = min(first, abs(found.time));
            last = max(last, abs(found.time));
        }
    }
    if (driven) atomicOr(wave_blocks[group].driven, 4u);
    if (surface) let_go(ivec3(block));
    if (first < FREE) {
        atomicMax(wave_blocks[group].first, ~floatBitsToUint(first));
        atomicMax(wave_blocks[group].last, floatBitsToUint(last));
    }
}
