// Walks along the edges of beams through their media, one invocation an edge. renderer/technique/beams/accumulate/depths.rs.
#include "shared/index.glsl"
#include "shared/media.glsl"
#include "technique/beams/stored.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/beam_depths.glsl"

layout(set = 3, binding = 8, std430) writeonly buffer AllBeamDepths { BeamDepths beam_depths[]; };
layout(push_constant) uniform BeamDepthsPush { uint capacity; } push;

void main() {
    uint index = linear_index();
    if (index >= 3u * beam_count(push.capacity)) return;
    Beam beam = beams[index / 3u];
    if ((beam.flags & BEAM_EMPTY) != 0u || !beam_is_finite(beam) || media[beam.medium].grid == NO_GRID) return;
    BeamCorner corner = beam.corners[index % 3u];
    // Beams that end on different surfaces are followed to the last of them.
    vec3 ends = beam_ends(beam);
    float size = length(corner.way);
    float reach = max(max(ends.x, max(ends.y, ends.z)) - corner.start, 0.0) * size;
    vec3 from = corner.origin + corner.start * corner.way;
    vec3 way = corner.way / size;
    vec2 part = dense_part(beam.medium, from, way, reach);
    BeamDepths found;
    found.first = part.x;
    found.step = max(part.y - part.x, 0.0) / float(BEAM_PLACES);
    float depths[BEAM_PLACES];
    found.total = 0.0;
    for (uint i = 0u; i < BEAM_PLACES; i++) {
        vec3 place = from + (part.x + float(i) * found.step) * way;
        found.total += density_along(beam.medium, place, way, found.step);
        depths[i] = found.total;
    }
    // Parts, since halves of the depths themselves could overflow.
    float scale = found.total > 0.0 ? 1.0 / found.total : 0.0;
    for (uint i = 0u; i < BEAM_PLACES / 2u; i++) {
        found.parts[i] = packHalf2x16(scale * vec2(depths[2u * i], depths[2u * i + 1u]));
    }
    beam_depths[index] = found;
}
