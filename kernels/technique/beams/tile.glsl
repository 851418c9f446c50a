// Slots in tiles of 64, one workgroup each. Where places are pixels a tile is 8 x 8 of them; in adaptive rounds places in a
// row are samples of neighbouring pixels, so there a tile is 64 in a row.
#include "shared/view.glsl"
#include "shared/visible.glsl"

struct TilePush {
    uint capacity; // beams
    uint blocks;   // boxes of blocks, after which those of groups come
    uint listed;   // 1: places are those of an adaptive round
    uint drawn;    // 1: what the camera sees straight is drawn by a rasteriser
    uint first;    // tile of the dispatch
    uint padding0;
    uint padding1;
    uint padding2;
};

const uint TILE_SIDE = 8u;
const uint TILE_SLOTS = 64u;
const uint NO_SLOT = 0xffffffffu;

// This workgroup's.
uint own_tile(TilePush push) {
    return push.first + gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
}

uint tiles_across() {
    return (view.width + TILE_SIDE - 1u) / TILE_SIDE;
}

uint tiles_in_layer(TilePush push) {
    if (push.listed != 0u) return (view.width * view.rows + TILE_SLOTS - 1u) / TILE_SLOTS;
    return tiles_across() * ((view.rows + TILE_SIDE - 1u) / TILE_SIDE);
}

// This invocation's slot; NO_SLOT outside of the picture.
uint slot_of(TilePush push, uint tile) {
    uint in_layer = tiles_in_layer(push);
    uint layer = tile / in_layer;
    uint index = tile % in_layer;
    uint pixels = view.width * view.rows;
    if (push.listed != 0u) {
        uint place = index * TILE_SLOTS + gl_LocalInvocationIndex;
        return place < pixels ? layer * pixels + place : NO_SLOT;
    }
    uint across = tiles_across();
    // Eight in a row are four by two pixels.
    uint lane = gl_LocalInvocationIndex;
    uint x = (index % across) * TILE_SIDE + (lane & 3u) + (lane >> 1 & 4u);
    uint y = (index / across) * TILE_SIDE + (lane >> 2 & 1u) + (lane >> 3 & 6u);
    return x < view.width && y < view.rows ? layer * pixels + y * view.width + x : NO_SLOT;
}
