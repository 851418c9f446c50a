// The grid of the scalar wave (Mercier's Algorithm 3): the volume's cells, a border of columns around them in which the wave is
// damped, and a rim of zeros around all. Structs as in renderer/technique/eikonal/wave/device.rs.
#include "technique/eikonal/grid.glsl"

// Cells of a block along u, v and planes. An invocation has a tile of it, TILE cells along u and v in each plane.
const ivec3 WAVE_BLOCK = ivec3(16, 16, 4);
const ivec2 TILE = ivec2(8, 2);
const int TILES_U = 2;
const uint TILES = 16u;

struct WaveGrid {
    uvec3 cells;   // the volume's, along u, v and the way of planes
    int first;     // index of the volume's cell (0, 0, 0) of columns and planes
    ivec3 strides; // of the volume, from one cell to the next
    uint border;   // columns beyond the volume's on each side
    uvec3 blocks;
    uint top;      // planes before the volume's first
};

struct WaveBlock {
    uint even;      // the last turn of even number that this block is to be stepped in
    uint odd;       // of odd number
    uint driven;    // 4 where some of its cells are not simply stepped, else 0
    uint first;     // ~bits of the first time at which a wave comes in here; 0: none does
    uint last;      // bits of the last
    uint padding0;
};

// In place of a time: stepped like any cell, and nothing comes in.
const float FREE = UNKNOWN;

const uint SUM_SIGNED = 0u;
const uint SUM_ABSOLUTE = 1u;

// The pulse that comes in, at `time` cells after its middle; 1 at most. It is odd, since what is slow of a pulse with a mean does
// not focus, save where its values are summed with their signs.
float pulse_at(float time, float width, uint sum) {
    float t = time / width;
    float bell = exp(-0.5 * t * t);
    return sum == SUM_SIGNED ? bell : 1.6487213 * t * bell;
}

// Times the width: from here on nothing is left of it.
const float PULSE_REACH = 3.8;

// Cells of a line along u, and lines of a plane, in the buffers of the wave: with a rim of zeros, whose width keeps fours of cells
// together.
ivec2 wave_pitch(WaveGrid grid) {
    return ivec2(grid.blocks.xy) * WAVE_BLOCK.xy + ivec2(8, 2);
}

// Index there of a place in border and volume.
int wave_index(WaveGrid grid, ivec3 at) {
    ivec2 pitch = wave_pitch(grid);
    return ((at.z + 1) * pitch.y + at.y + 1) * pitch.x + at.x + 4;
}

// A place's cell of the volume, which may lie outside of it.
ivec3 volume_place(WaveGrid grid, ivec3 at) {
    return at - ivec3(grid.border, grid.border, grid.top);
}

int volume_index(WaveGrid grid, ivec3 at) {
    return grid.first + at.x * grid.strides.x + at.y * grid.strides.y + at.z * grid.strides.z;
}

// The first cell of a block's tile.
ivec3 tile_place(uvec3 block, uint tile) {
    return ivec3(block) * WAVE_BLOCK + ivec3(TILE * ivec2(int(tile) % TILES_U, int(tile) / TILES_U), 0);
}
