// The light that all beams scatter into the stretches of camera paths that lie in media, one workgroup a tile. The tile's
// k-th stretches, whatever surfaces bent them, lie between four planes that the nearest and the farthest cut through all of
// them tell.
layout(local_size_x = 64) in;
#include "shared/film.glsl"
#include "technique/beams/inscatter.glsl"
#include "technique/beams/shadow.glsl"
#include "technique/beams/group_tally.glsl"
#include "technique/beams/traverse.glsl"
#include "technique/beams/shaft.glsl"

layout(set = 2, binding = 20, std430) writeonly buffer SampleVolume { vec4 sample_volume[]; };
layout(push_constant) uniform VolumeLightPush {
    TilePush tile;
    ShadePush shade;
    VolumePush volume;
} push;

Stretch view_ray; // this invocation's
Shaft shaft;      // round the tile's
vec3 sum = vec3(0.0);

bool near_box(BeamBox box) {
    return box_meets_shaft(box.low, box.high, shaft);
}

bool near_beam(Beam beam) {
    return beam_meets_shaft(beam, shaft);
}

void visit(uint bases[2], uvec2 near_beams) {
    while (any_bit(near_beams)) {
        uint bit = take_bit(near_beams);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
        if (beam.medium != view_ray.medium) continue;
        count(TALLY_TESTS);
        Crossing c = crossing_of(beam, view_ray.origin, view_ray.direction, view_ray.extent);
        vec2 part = part_between_ends(beam, c, view_ray.origin, view_ray.direction, view_ray.extent);
        vec2 seen = seen_part(view_ray) - c.centre;
        part = vec2(max(part.x, seen.x), min(part.y, seen.y));
        float ends[MAX_PIECES + 1u];
        uint count_of_ends = 2u;
        if (push.volume.scan_plane != 0u) {
            part = scan_plane_part(beam, c, view_ray.origin, view_ray.direction, part);
            ends[0] = part.x;
            ends[1] = part.y;
        } else if (part.x < part.y) {
            count_of_ends = side_crossings(c, part, ends);
        }
        if (!(part.x < part.y)) continue;
        for (uint piece = 0u; piece + 1u < count_of_ends; piece++) {
            vec2 between = vec2(ends[piece], ends[piece + 1u]);
            float middle = 0.5 * (between.x + between.y);
            bool inside = push.volume.scan_plane != 0u || is_inside(beam, c, view_ray.origin, view_ray.direction, middle);
            if (!inside || !(between.x < between.y)) continue;
            count(TALLY_FRAGMENTS);
            if ((beam.flags & BEAM_STRADDLES) != 0u) {
                Section section = section_along(beam, c, middle);
                vec3 point = view_ray.origin + (c.centre + middle) * view_ray.direction;
                float before = section.y - dot(section.weights, beam_starts(beam));
                count(TALLY_RAYS);
                if (before > 0.0 && is_shadowed(beam, point, point - before * section.way)) {
                    count(TALLY_SHADOWED);
                    continue;
                }
            }
            vec3 found = piece_integral(push.shade, push.volume, beam, view_ray, c, between);
            found *= beam.flux * view_ray.throughput;
            if (all_finite(found)) {
                sum += found;
            } else {
                count(TALLY_NON_FINITE);
            }
        }
    }
}

void main() {
    uint tile = gl_WorkGroupID.x + gl_WorkGroupID.y * gl_NumWorkGroups.x;
    if (tile >= VISIBLE_LAYERS * tiles_in_layer(push.tile)) return;
    uint slot = slot_of(push.tile, tile);
    open_tallies();
    open_votes();
    for (uint k = 0u; k < view.segments; k++) {
        view_ray.medium = NO_MEDIUM;
        if (slot != NO_SLOT) view_ray = stretch(k, slot, view.width * view.rows * VISIBLE_LAYERS);
        uint found_media;
        shaft = shaft_round(view_ray, found_media);
        traverse(push.tile, found_media);
    }
    if (slot != NO_SLOT) sample_volume[slot] = vec4(sum, 0.0);
    close_tallies();
}
