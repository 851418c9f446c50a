// One step of the scalar wave (Mercier's equation 5) in those blocks where there is any of it. With w for the mean over three cells
// in a row weighed 1, 2, 1, along all three axes, a cell's value after next is 4 w - 2 now - before: leapfrog with a step that
// light takes a cell in, whose waves obey cos(omega / 2) = product of cos(k_i / 2). Along the axes that is no dispersion at all,
// so that pulses of a few cells keep their shape, where the stencil of six neighbours would smear them out. (Kowalczyk and van
// Walstijn 2011, interpolated wideband.)
#include "shared/index.glsl"
#include "technique/eikonal/wave.glsl"

layout(set = 3, binding = 7, std430) readonly buffer WaveNow { vec4 now[]; };
layout(set = 3, binding = 8, std430) buffer WaveBefore { vec4 before[]; }; // and after
layout(set = 3, binding = 9, std430) buffer WaveSums { vec4 sums[]; };
layout(set = 3, binding = 10, std430) readonly buffer WaveArrivals { float arrivals[]; };
layout(set = 3, binding = 11, std430) readonly buffer WaveAmplitudes { float amplitudes[]; };
layout(set = 3, binding = 12, std430) buffer WaveBlocks { WaveBlock wave_blocks[]; };
layout(set = 3, binding = 13, std430) buffer WaveTally {
    uint stepped; // blocks, over all turns
    uint turns;   // that there was any wave in
} tally;
layout(push_constant) uniform WaveStepPush {
    WaveGrid grid;
    uint turn;
    uint sum;      // SUM_...
    float quiet;   // below this there is no wave
    float width;   // of the pulse, cells
    float damping; // a step, in the border's outermost columns
    uint strands;  // in which a column's blocks are looked at, one after the other in each
} push;

// Of a plane, the cells of a tile: two fours of the first line, two of the second.
struct Tile {
    vec4 a;
    vec4 b;
    vec4 c;
    vec4 d;
};

// A line's eight cells and the one on either side. Fours are read at once: on llvmpipe that costs little more than one.
struct Line {
    float before;
    vec4 a;
    vec4 b;
    float after;
};

Line line_at(int at) {
    return Line(now[at - 1].w, now[at], now[at + 1], now[at + 2].x);
}

// Three lines weighed 1, 2, 1.
Line weigh(Line l, Line m, Line r) {
    return Line(l.before + 2.0 * m.before + r.before, l.a + 2.0 * m.a + r.a, l.b + 2.0 * m.b + r.b, l.after + 2.0 * m.after + r.after);
}

// The same along a line.
vec4 weigh_first(Line l) {
    return vec4(l.before, l.a.xyz) + 2.0 * l.a + vec4(l.a.yzw, l.b.x);
}

vec4 weigh_second(Line l) {
    return vec4(l.a.w, l.b.xyz) + 2.0 * l.b + vec4(l.b.yzw, l.after);
}

// Sums over a tile's cells and their neighbours in its plane, and the cells themselves. `at`: the tile's first four, `row`: fours
// from line to line.
Tile plane_sum(int at, int row, out Tile middle) {
    Line p = line_at(at - row);
    Line q = line_at(at);
    Line r = line_at(at + row);
    Line s = line_at(at + 2 * row);
    middle = Tile(q.a, q.b, r.a, r.b);
    Line upper = weigh(p, q, r);
    Line lower = weigh(q, r, s);
    return Tile(weigh_first(upper), weigh_second(upper), weigh_first(lower), weigh_second(lower));
}

// How much a cell is damped in a step, growing as the square of how deep it lies in the border.
float damping_at(ivec2 column) {
    ivec2 beyond = max(max(-column, column - ivec2(push.grid.cells.xy) + 1), ivec2(0));
    vec2 deep = min(vec2(beyond) / float(max(push.grid.border, 1u)), vec2(1.0));
    return push.damping * dot(deep, deep);
}

// What becomes of a cell that is not simply stepped: what is known of it at all times, or damped towards what comes in there.
float settle(float after, float was, int index, ivec3 at) {
    float arrival = arrivals[index];
    if (arrival == OUTSIDE) return 0.0;
    float amplitude = amplitudes[index];
    float time = float(push.turn + 1u) - abs(arrival);
    bool near = amplitude > 0.0 && abs(time - 1.0) < PULSE_REACH * push.width + 1.0;
    if (arrival < 0.0) return near ? amplitude * pulse_at(time, push.width, push.sum) : 0.0;
    float half_damping = 0.5 * damping_at(volume_place(push.grid, at).xy);
    float comes = 0.0;
    if (near) comes = amplitude * (pulse_at(time, push.width, push.sum) - pulse_at(time - 2.0, push.width, push.sum));
    return (after + half_damping * (was + comes)) / (1.0 + half_damping);
}

void wake_at(uint index, uint turn) {
    if ((turn & 1u) == 0u) atomicMax(wave_blocks[index].even, turn);
    else atomicMax(wave_blocks[index].odd, turn);
}

// Of what counts as a wave, what the blocks before and after along planes are stepped for where a tile holds a wave: what of its foot
// comes to a block that is not stepped stays behind it for good, and flat water would be 1 % off in places.
const float FOOT = 0.25;

// Has a block stepped in the next two turns, so that little is left in it when it is left alone, and those next to where a tile
// of it holds some of the wave in the next. A wave goes a cell in a step.
void wake(uvec3 block, uint tile, float first, float last) {
    ivec3 low = ivec3(block);
    ivec3 high = low;
    ivec2 place = ivec2(int(tile) % TILES_U, int(tile) / TILES_U);
    ivec2 end = WAVE_BLOCK.xy / TILE - 1;
    bool up = first > FOOT * push.quiet;
    bool down = last > FOOT * push.quiet;
    low -= ivec3(equal(ivec3(place, up ? 0 : 1), ivec3(0)));
    high += ivec3(equal(ivec3(place, down ? 0 : 1), ivec3(end, 0)));
    low = max(low, ivec3(0));
    high = min(high, ivec3(push.grid.blocks) - 1);
    for (int z = low.z; z <= high.z; z++) {
        for (int y = low.y; y <= high.y; y++) {
            for (int x = low.x; x <= high.x; x++) {
                uint index = (uint(z) * push.grid.blocks.y + uint(y)) * push.grid.blocks.x + uint(x);
                wake_at(index, push.turn + 1u);
                // Only a block's own tiles get here, and only while it is stepped, so that none of them finds it asleep.
                if (uvec3(x, y, z) == block) wake_at(index, push.turn + 2u);
            }
        }
    }
}

// A four's next values from sums over neighbours.
vec4 stepped(vec4 behind, vec4 here, vec4 ahead, vec4 middle, vec4 was) {
    vec4 mean = (behind + 2.0 * here + ahead) / 16.0;
    // At first the wave stands still: what was before is what comes after.
    return push.turn == 0u ? 0.5 * mean - middle : mean - 2.0 * middle - was;
}

float most_of(vec4 v) {
    return max(max(v.x, v.y), max(v.z, v.w));
}

// Puts a four in its place; how much there is of the wave. `driven`: 4 where its cells are not simply stepped, else 0; a bound that
// compilers know would make them write this out sixteen times.
float put(vec4 after, vec4 middle, vec4 was, int at, ivec3 cell, int driven) {
    for (int i = 0; i < driven; i++) {
        after[i] = settle(after[i], push.turn == 0u ? after[i] : was[i], 4 * at + i, cell + ivec3(i, 0, 0));
    }
    before[at] = after;
    sums[at] += push.sum == SUM_SIGNED ? after : push.sum == SUM_ABSOLUTE ? abs(after) : after * after;
    return most_of(max(abs(after), abs(middle)));
}

void step_tile(uvec3 block, uint tile, int driven) {
    WaveGrid grid = push.grid;
    ivec3 place = tile_place(block, tile);
    int row = wave_pitch(grid).x / 4;
    int slab = row * wave_pitch(grid).y;
    int at = wave_index(grid, place) / 4 - slab;
    bool last_block = block.z + 1u == grid.blocks.z;
    bool first_block = grid.top > 0u && block.z == 0u;
    Tile none = Tile(vec4(0.0), vec4(0.0), vec4(0.0), vec4(0.0));
    Tile last_middle = none;
    Tile middle = none;
    Tile behind = none;
    Tile here = none;
    float most = 0.0;
    float first = 0.0;
    float last = 0.0;
    // A plane's sums are taken once, two planes before the last one that needs them.
    for (int plane = -2; plane < WAVE_BLOCK.z; plane++) {
        Tile next_middle;
        Tile ahead = plane_sum(at, row, next_middle);
        if (plane >= 0) {
            int to = at - slab;
            Tile was = Tile(before[to], before[to + 1], before[to + row], before[to + row + 1]);
            Tile after;
            after.a = stepped(behind.a, here.a, ahead.a, middle.a, was.a);
            after.b = stepped(behind.b, here.b, ahead.b, middle.b, was.b);
            after.c = stepped(behind.c, here.c, ahead.c, middle.c, was.c);
            after.d = stepped(behind.d, here.d, ahead.d, middle.d, was.d);
            // The wave leaves through the first and the last plane: straight on it is not thrown back at all, aslant little.
            if (last_block && plane == WAVE_BLOCK.z - 1) after = last_middle;
            if (first_block && plane == 0) after = next_middle;
            ivec3 cell = place + ivec3(0, 0, plane);
            last = put(after.a, middle.a, was.a, to, cell, driven);
            last = max(last, put(after.b, middle.b, was.b, to + 1, cell + ivec3(4, 0, 0), driven));
            last = max(last, put(after.c, middle.c, was.c, to + row, cell + ivec3(0, 1, 0), driven));
            last = max(last, put(after.d, middle.d, was.d, to + row + 1, cell + ivec3(4, 1, 0), driven));
            if (plane == 0) first = last;
            most = max(most, last);
        }
        behind = here;
        here = ahead;
        last_middle = middle;
        middle = next_middle;
        at += slab;
    }
    if (most > push.quiet) wake(block, tile, first, last);
}

void main() {
    uint index = linear_index();
    uint tile = index % TILES;
    uint strand = index / TILES;
    uvec3 blocks = push.grid.blocks;
    uint columns = blocks.x * blocks.y;
    if (strand >= columns * push.strands) return;
    uint column = strand % columns;
    float time = float(push.turn + 1u);
    float reach = PULSE_REACH * push.width + 1.0;
    for (uint z = strand / columns; z < blocks.z; z += push.strands) {
        uint at = z * columns + column;
        uint when = (push.turn & 1u) == 0u ? wave_blocks[at].even : wave_blocks[at].odd;
        uint first = wave_blocks[at].first;
        bool comes = first != 0u && time >= uintBitsToFloat(~first) - reach && time <= uintBitsToFloat(wave_blocks[at].last) + reach;
        if (comes || (when >= push.turn && push.turn > 0u)) {
            step_tile(uvec3(column % blocks.x, column / blocks.x, z), tile, int(wave_blocks[at].driven));
            if (tile == 0u) {
                atomicAdd(tally.stepped, 1u);
                atomicMax(tally.turns, push.turn + 1u);
            }
        }
    }
}
