// The light of all beams at the visible points, one workgroup a tile.
layout(local_size_x = 64) in;
#include "shared/film.glsl"
#include "technique/beams/shade.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/group_tally.glsl"
#include "technique/beams/traverse.glsl"
#include "technique/beams/ordered.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(push_constant) uniform LightPush {
    TilePush tile;
    ShadePush shade;
} push;

shared uint tile_bounds[6]; // low, then high
shared uint tile_media;

struct TileBox {
    vec3 low;
    vec3 high;
    uint media;
};

TileBox box; // round all points of the tile
VisiblePoint point;
bool here;      // whether there is one
vec3 shading;   // its normals
vec3 geometric;
vec3 sum = vec3(0.0);

TileBox tile_box() {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 6u) tile_bounds[lane] = lane < 3u ? 0xffffffffu : 0u;
    if (lane == 0u) tile_media = 0u;
    open_tallies();
    open_votes();
    barrier();
    if (here) {
        for (uint i = 0u; i < 3u; i++) {
            atomicMin(tile_bounds[i], ordered(point.position[i]));
            atomicMax(tile_bounds[3u + i], ordered(point.position[i]));
        }
        atomicOr(tile_media, medium_bit(point.medium));
    }
    barrier();
    TileBox found;
    for (uint i = 0u; i < 3u; i++) {
        found.low[i] = from_ordered(tile_bounds[i]);
        found.high[i] = from_ordered(tile_bounds[3u + i]);
    }
    found.media = tile_media;
    return found;
}

bool meets_tile(vec3 low, vec3 high) {
    return all(lessThanEqual(low, box.high)) && all(greaterThanEqual(high, box.low));
}

bool near_box(BeamBox beams_box) {
    return meets_tile(beams_box.low, beams_box.high);
}

// By a box round the part of the beam at the tile's heights along it.
bool near_beam(Beam beam) {
    vec3 middle = 0.5 * (box.low + box.high) - beam.corners[0].origin;
    float y = dot(beam.normal, middle);
    float extent = dot(abs(beam.normal), 0.5 * (box.high - box.low));
    extent += 1e-5 * (abs(y) + extent);
    vec2 range = beam_range(beam);
    range = vec2(max(range.x, y - extent), min(range.y, y + extent));
    if (!(range.x <= range.y)) return false;
    vec3 low, high;
    box_of_range(beam, range, low, high);
    return meets_tile(low, high);
}

void visit(uint bases[2], uvec2 near_beams) {
    uvec2 inside = uvec2(0u);
    while (any_bit(near_beams)) {
        uint bit = take_bit(near_beams);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
        if (!here || beam.medium != point.medium) continue;
        count(TALLY_TESTS);
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
            count(TALLY_NON_FINITE);
            continue;
        }
        if (mean(found) <= 0.0) continue;
        count(TALLY_FRAGMENTS);
        if (wants_ray(beam, section, push.shade.shadows)) {
            count(TALLY_RAYS);
            if (is_shadowed(beam, point.position, start)) {
                count(TALLY_SHADOWED);
                continue;
            }
        }
        sum += found;
    }
}

void main() {
    uint tile = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
    if (tile >= VISIBLE_LAYERS * tiles_in_layer(push.tile)) return;
    uint slot = slot_of(push.tile, tile);
    point = VisiblePoint(vec3(0.0), NO_INSTANCE, 0u, 0u, 0.0, 0u);
    if (slot != NO_SLOT) point = visible_points[slot];
    here = point.instance != NO_INSTANCE;
    shading = unpack_direction(point.normal);
    geometric = unpack_direction(point.geometric);
    box = tile_box();
    traverse(push.tile, box.media);
    if (slot != NO_SLOT) sample_irradiance[slot] = vec4(sum, 0.0);
    close_tallies();
}
