// Finds the beams near a tile, one workgroup. Groups of blocks of beams, then blocks, then beams are held against what is
// round the tile, 64 at once, and those that are left are handed on in the order in which they are stored: no lists, no
// room to run out of, and equal bits.
#include "technique/beams/stored.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/shaft.glsl"
#include "technique/beams/tile.glsl"
#include "technique/beams/vote.glsl"

layout(set = 3, binding = 2, std430) readonly buffer BeamBoxes { BeamBox beam_boxes[]; };

// Who includes this says whether a box, a block's shaft or a beam comes near its tile,
bool near_box(BeamBox box);
bool near_shaft(Shaft block);
bool near_beam(Beam beam);
// and takes what does: beams bases[bit / 32] + bit % 32 for each bit that is set.
void visit(uint bases[2], uvec2 near_beams);

bool wants_box(uint index, uint end, uint media) {
    if (index >= end) return false;
    BeamBox box = beam_boxes[index];
    return box.beams > 0u && (box.media & media) != 0u && near_box(box);
}

bool wants_block(uint index, uint end, uint media) {
    if (!wants_box(index, end, media)) return false;
    BeamBox box = beam_boxes[index];
    Shaft block;
    block.axis = box.axis;
    basis(block.axis, block.across[0], block.across[1]);
    block.ends = vec2(box.near, box.far);
    block.at_near = box.at_near;
    block.at_far = box.at_far;
    return near_shaft(block);
}

bool wants_beam(uint index, uint end, uint media) {
    if (index >= end) return false;
    Beam beam = beams[index];
    bool other = (medium_bit(beam.medium) & media) == 0u;
    return !other && (beam.flags & BEAM_EMPTY) == 0u && beam_is_finite(beam) && near_beam(beam);
}

// `media`: the bits of all media that the tile is in. In uniform control flow.
void traverse(TilePush push, uint media) {
    uint lane = gl_LocalInvocationIndex;
    uint beams_in_use = beam_count(push.capacity);
    uint blocks = (beams_in_use + BLOCK_BEAMS - 1u) / BLOCK_BEAMS;
    uint groups = media == 0u ? 0u : (blocks + GROUP_BLOCKS - 1u) / GROUP_BLOCKS;
    for (uint first_group = 0u; first_group < groups; first_group += VOTERS) {
        uvec2 near_groups = vote(wants_box(push.blocks + first_group + lane, push.blocks + groups, media));
        while (any_bit(near_groups)) {
            uint first_block = (first_group + take_bit(near_groups)) * GROUP_BLOCKS;
            uvec2 near_blocks = vote(lane < GROUP_BLOCKS && wants_block(first_block + lane, blocks, media));
            while (any_bit(near_blocks)) {
                // Two blocks at once.
                uint bases[2];
                bases[0] = (first_block + take_bit(near_blocks)) * BLOCK_BEAMS;
                bases[1] = any_bit(near_blocks) ? (first_block + take_bit(near_blocks)) * BLOCK_BEAMS : beams_in_use;
                uint index = bases[lane / BLOCK_BEAMS] + lane % BLOCK_BEAMS;
                visit(bases, vote(wants_beam(index, beams_in_use, media)));
            }
        }
    }
}
