// The light that all beams scatter into the stretches of camera paths that lie in media, one workgroup a tile. The tile's
// k-th stretches, whatever surfaces bent them, lie between four planes that the nearest and the farthest cut through all of
// them tell.
layout(local_size_x = 64) in;
#include "shared/film.glsl"
#include "technique/beams/volume_light.glsl"
#include "technique/beams/group_tally.glsl"
#include "technique/beams/traverse.glsl"
#include "technique/beams/tile_shaft.glsl"
#ifndef EVEN_MEDIA
#include "technique/beams/seen_depths.glsl"
#endif

layout(set = 2, binding = 20, std430) writeonly buffer SampleVolume { vec4 sample_volume[]; };
// What rasterised hulls brought, a pixel; w: their fragments.
layout(set = 3, binding = 7, std430) readonly buffer DrawnVolume { vec4 drawn_volume[]; };
layout(push_constant) uniform VolumeLightPush {
    TilePush tile;
    ShadePush shade;
    VolumePush volume;
} push;

Stretch view_ray; // this invocation's
vec2 seen;        // what of it can be bright
Shaft shaft;      // round the tile's
vec3 sum = vec3(0.0);

bool near_box(BeamBox box) {
    return box_meets_shaft(box.low, box.high, shaft);
}

bool near_shaft(Shaft block) {
    return shafts_meet(block, shaft);
}

bool near_beam(Beam beam) {
    return beam_meets_shaft(beam, shaft);
}

void visit(uint bases[2], uvec2 near_beams) {
    uvec2 met = uvec2(0u);
    uvec2 straddling = uvec2(0u);
    while (any_bit(near_beams)) {
        uint bit = take_bit(near_beams);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
        count(TALLY_TESTS);
        if (!may_light(beam, view_ray)) continue;
        met[bit / 32u] |= 1u << (bit % 32u);
        if ((beam.flags & BEAM_STRADDLES) != 0u) straddling[bit / 32u] |= 1u << (bit % 32u);
    }
    while (any_bit(straddling)) {
        uint bit = take_bit(straddling);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
        if (is_hidden(push.volume, beam, view_ray, seen)) met[bit / 32u] &= ~(1u << (bit % 32u));
    }
    float from = -ALL_DONE;
    while (any_bit(met)) {
        uvec2 rest = met;
        uint bit = take_bit(rest);
        uint index = bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS;
        sum += volume_step(push.shade, push.volume, index, beams[index], view_ray, seen, from);
        if (from >= ALL_DONE) {
            met = rest;
            from = -ALL_DONE;
        }
    }
}

void main() {
    uint tile = own_tile(push.tile);
    if (tile >= VISIBLE_LAYERS * tiles_in_layer(push.tile)) return;
    uint slot = slot_of(push.tile, tile);
    open_tallies();
    open_votes();
    bool drawn = push.tile.drawn != 0u && slot < view.width * view.rows;
    if (drawn) {
        sum = drawn_volume[slot].rgb;
        count_drawn(drawn_volume[slot].w);
    }
    for (uint k = 0u; k < view.segments; k++) {
        view_ray.medium = NO_MEDIUM;
        if (slot != NO_SLOT) view_ray = stretch(k, slot, view.width * view.rows * VISIBLE_LAYERS);
        // Drawn, where the path comes straight from the camera.
        if (drawn && k == 0u && view_ray.origin == view.position) view_ray.medium = NO_MEDIUM;
        seen = view_ray.medium != NO_MEDIUM ? seen_part(view_ray) : vec2(0.0);
#ifndef EVEN_MEDIA
        note_depths(view_ray);
#endif
        uint found_media;
        shaft = shaft_round(view_ray, found_media);
        traverse(push.tile, found_media);
    }
    if (slot != NO_SLOT) sample_volume[slot] = vec4(sum, 0.0);
    close_tallies();
}
