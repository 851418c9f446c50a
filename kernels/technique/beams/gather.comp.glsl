// The light of all beams at the visible points, one workgroup a tile. Groups of blocks of beams, then blocks, then beams
// are held against the box round the tile's points, 64 at once, and each point looks at the beams that are left: nothing
// is stored, nothing can overflow, and every point adds up in the order of the beams.
layout(local_size_x = 64) in;
#include "shared/film.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/shade.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/tally.glsl"
#include "technique/beams/tile.glsl"
#include "technique/beams/vote.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 3, binding = 2, std430) readonly buffer BeamBoxes { BeamBox beam_boxes[]; };
layout(push_constant) uniform LightPush {
    TilePush tile;
    ShadePush shade;
} push;

shared uint tile_bounds[6]; // low, then high, so that the numbers are in the order of the floats
shared uint tile_media;
shared uint tile_tallies[TALLIES];

uint ordered(float value) {
    uint bits = floatBitsToUint(value);
    return (bits & 0x80000000u) != 0u ? ~bits : bits | 0x80000000u;
}

float from_ordered(uint bits) {
    return uintBitsToFloat((bits & 0x80000000u) != 0u ? bits & 0x7fffffffu : ~bits);
}

struct TileBox {
    vec3 low;
    vec3 high;
    uint media;
};

// Round all points of the workgroup's that are there.
TileBox tile_box(bool here, vec3 point, uint medium) {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 6u) tile_bounds[lane] = lane < 3u ? 0xffffffffu : 0u;
    if (lane == 0u) tile_media = 0u;
    if (lane < TALLIES) tile_tallies[lane] = 0u;
    open_votes();
    barrier();
    if (here) {
        for (uint i = 0u; i < 3u; i++) {
            atomicMin(tile_bounds[i], ordered(point[i]));
            atomicMax(tile_bounds[3u + i], ordered(point[i]));
        }
        atomicOr(tile_media, medium_bit(medium));
    }
    barrier();
    TileBox box;
    for (uint i = 0u; i < 3u; i++) {
        box.low[i] = from_ordered(tile_bounds[i]);
        box.high[i] = from_ordered(tile_bounds[3u + i]);
    }
    box.media = tile_media;
    return box;
}

bool boxes_meet(vec3 low, vec3 high, TileBox tile) {
    return all(lessThanEqual(low, tile.high)) && all(greaterThanEqual(high, tile.low));
}

bool wants_box(uint index, uint end, TileBox tile) {
    if (index >= end) return false;
    BeamBox box = beam_boxes[index];
    return box.beams > 0u && (box.media & tile.media) != 0u && boxes_meet(box.low, box.high, tile);
}

// By a box round the part of the beam at the tile's heights along it.
bool wants_beam(uint index, uint end, TileBox tile) {
    if (index >= end) return false;
    Beam beam = beams[index];
    bool other = (medium_bit(beam.medium) & tile.media) == 0u;
    if (other || (beam.flags & BEAM_EMPTY) != 0u || !beam_is_finite(beam)) return false;
    vec3 middle = 0.5 * (tile.low + tile.high) - beam.corners[0].origin;
    float y = dot(beam.normal, middle);
    float extent = dot(abs(beam.normal), 0.5 * (tile.high - tile.low));
    extent += 1e-5 * (abs(y) + extent);
    vec2 range = beam_range(beam);
    range = vec2(max(range.x, y - extent), min(range.y, y + extent));
    if (!(range.x <= range.y)) return false;
    vec3 low, high;
    box_of_range(beam, range, low, high);
    return boxes_meet(low, high, tile);
}

void main() {
    uint tile = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
    if (tile >= VISIBLE_LAYERS * tiles_in_layer(push.tile)) return;
    uint slot = slot_of(push.tile, tile);
    VisiblePoint point = VisiblePoint(vec3(0.0), NO_INSTANCE, 0u, 0u, 0.0, 0u);
    if (slot != NO_SLOT) point = visible_points[slot];
    bool here = point.instance != NO_INSTANCE;
    TileBox box = tile_box(here, point.position, point.medium);
    vec3 shading = unpack_direction(point.normal);
    vec3 geometric = unpack_direction(point.geometric);

    uint lane = gl_LocalInvocationIndex;
    uint beams_in_use = beam_count(push.tile.capacity);
    uint blocks = (beams_in_use + BLOCK_BEAMS - 1u) / BLOCK_BEAMS;
    uint groups = box.media == 0u ? 0u : (blocks + GROUP_BLOCKS - 1u) / GROUP_BLOCKS;
    vec3 sum = vec3(0.0);
    uint tallies[TALLIES] = uint[TALLIES](0u, 0u, 0u, 0u, 0u);
    for (uint first_group = 0u; first_group < groups; first_group += VOTERS) {
        uvec2 near_groups = vote(wants_box(push.tile.blocks + first_group + lane, push.tile.blocks + groups, box));
        while (any_bit(near_groups)) {
            uint first_block = (first_group + take_bit(near_groups)) * GROUP_BLOCKS;
            uvec2 near_blocks = vote(lane < GROUP_BLOCKS && wants_box(first_block + lane, blocks, box));
            while (any_bit(near_blocks)) {
                // Two blocks at once.
                uint bases[2];
                bases[0] = (first_block + take_bit(near_blocks)) * BLOCK_BEAMS;
                bases[1] = any_bit(near_blocks) ? (first_block + take_bit(near_blocks)) * BLOCK_BEAMS : beams_in_use;
                uvec2 near_beams = vote(wants_beam(bases[lane / BLOCK_BEAMS] + lane % BLOCK_BEAMS, beams_in_use, box));
                uvec2 inside = uvec2(0u);
                while (any_bit(near_beams)) {
                    uint bit = take_bit(near_beams);
                    Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
                    if (!here || beam.medium != point.medium) continue;
                    tallies[TALLY_TESTS]++;
                    Section section;
                    if (section_at(beam, point.position, section) && section.y <= beam_range(beam).y) {
                        inside[bit / 32u] |= 1u << (bit % 32u);
                    }
                }
                // Apart from the tests, so that invocations of one subgroup look at theirs together.
                while (any_bit(inside)) {
                    uint bit = take_bit(inside);
                    Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
                    Section section;
                    section_at(beam, point.position, section);
                    vec3 start;
                    vec3 found = beam_irradiance(push.shade, beam, section, point.position, shading, geometric, start);
                    if (!all_finite(found) || !all_finite(start)) {
                        tallies[TALLY_NON_FINITE]++;
                        continue;
                    }
                    if (mean(found) <= 0.0) continue;
                    tallies[TALLY_FRAGMENTS]++;
                    if (wants_ray(beam, section, push.shade.shadows)) {
                        tallies[TALLY_RAYS]++;
                        if (is_shadowed(beam, point.position, start)) {
                            tallies[TALLY_SHADOWED]++;
                            continue;
                        }
                    }
                    sum += found;
                }
            }
        }
    }
    if (slot != NO_SLOT) sample_irradiance[slot] = vec4(sum, 0.0);
    for (uint i = 0u; i < TALLIES; i++) {
        if (tallies[i] > 0u) atomicAdd(tile_tallies[i], tallies[i]);
    }
    barrier();
    if (lane < TALLIES) tally(lane, tile_tallies[lane]);
}
