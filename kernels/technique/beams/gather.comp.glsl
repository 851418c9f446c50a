// The light of all beams at the visible points, or on what their pixels cover, one workgroup a tile.
layout(local_size_x = 64) in;
#include "shared/film.glsl"
#include "technique/beams/surface_light.glsl"
#include "technique/beams/group_tally.glsl"
#include "technique/beams/traverse.glsl"
#include "technique/beams/ordered.glsl"
#include "technique/beams/footprint.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 12, std430) writeonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };
// What rasterised hulls brought, a pixel; w: their fragments.
layout(set = 3, binding = 6, std430) readonly buffer DrawnIrradiance { vec4 drawn_irradiance[]; };
layout(push_constant) uniform LightPush {
    TilePush tile;
    ShadePush shade;
    vec2 jitter;     // of the sample in its pixel
    uint footprints; // 1: what pixels cover, 0: their points
    uint parts;      // PARTS
} push;

// Eight invocations in a row are a part of the tile of four by two pixels, which sees fewer beams than the tile.
const uint PARTS = 8u;
shared uint part_bounds[PARTS][6]; // low, then high
shared uint part_beams[PARTS][2];  // bits of the beams that come near
shared uint tile_media;

struct Box {
    vec3 low;
    vec3 high;
};

Box box; // round all of the tile
VisiblePoint point;
Footprint footprint;
bool here;      // whether there is a point
vec3 shading;   // its normals
vec3 geometric;
vec3 sum = vec3(0.0);

Box part_box(uint part) {
    Box found;
    for (uint i = 0u; i < 3u; i++) {
        found.low[i] = from_ordered(part_bounds[part][i]);
        found.high[i] = from_ordered(part_bounds[part][3u + i]);
    }
    return found;
}

// Opens boxes round what this invocation looks at.
uint find_boxes(Box own) {
    uint lane = gl_LocalInvocationIndex;
    if (lane < PARTS) {
        for (uint i = 0u; i < 6u; i++) part_bounds[lane][i] = i < 3u ? 0xffffffffu : 0u;
    }
    if (lane == 0u) tile_media = 0u;
    if (lane < PARTS) part_beams[lane] = uint[2](0u, 0u);
    open_tallies();
    open_votes();
    barrier();
    if (here) {
        for (uint i = 0u; i < 3u; i++) {
            atomicMin(part_bounds[lane / PARTS][i], ordered(own.low[i]));
            atomicMax(part_bounds[lane / PARTS][3u + i], ordered(own.high[i]));
        }
        atomicOr(tile_media, medium_bit(point.medium));
    }
    barrier();
    // A part without points keeps bounds that hold nothing, and takes none from the others.
    uint low[3] = uint[3](0xffffffffu, 0xffffffffu, 0xffffffffu);
    uint high[3] = uint[3](0u, 0u, 0u);
    for (uint part = 0u; part < PARTS; part++) {
        for (uint i = 0u; i < 3u; i++) {
            low[i] = min(low[i], part_bounds[part][i]);
            high[i] = max(high[i], part_bounds[part][3u + i]);
        }
    }
    for (uint i = 0u; i < 3u; i++) {
        box.low[i] = from_ordered(low[i]);
        box.high[i] = from_ordered(high[i]);
    }
    return tile_media;
}

bool meet(vec3 low, vec3 high, Box other) {
    return all(lessThanEqual(low, other.high)) && all(greaterThanEqual(high, other.low));
}

bool near_box(BeamBox beams_box) {
    return meet(beams_box.low, beams_box.high, box);
}

// By a box round the part of it at the tile's places along it.
bool near_shaft(Shaft block) {
    float at = dot(0.5 * (box.low + box.high), block.axis);
    float extent = dot(abs(block.axis), 0.5 * (box.high - box.low));
    extent += 1e-5 * (abs(at) + extent);
    vec2 range = vec2(max(block.ends.x, at - extent), min(block.ends.y, at + extent));
    if (!(range.x <= range.y)) return false;
    vec3 low = vec3(3e38);
    vec3 high = vec3(-3e38);
    for (uint i = 0u; i < 8u; i++) {
        vec3 corner = shaft_corner(block, i & 3u, i < 4u ? range.x : range.y);
        low = min(low, corner);
        high = max(high, corner);
    }
    return meet(low, high, box);
}

// By a box round the part of the beam at the heights along it of what is in `other`.
bool comes_near(Beam beam, Box other) {
    vec3 middle = 0.5 * (other.low + other.high) - beam.corners[0].origin;
    float y = dot(beam.normal, middle);
    float extent = dot(abs(beam.normal), 0.5 * (other.high - other.low));
    extent += 1e-5 * (abs(y) + extent);
    vec2 range = beam_range(beam);
    range = vec2(max(range.x, y - extent), min(range.y, y + extent));
    if (!(range.x <= range.y)) return false;
    vec3 low, high;
    box_of_range(beam, range, low, high);
    return meet(low, high, other);
}

bool near_beam(Beam beam) {
    return comes_near(beam, box);
}

// Where the beam's light that falls into the pixel arrives, and how much of it, 1/m2.
bool meets_footprint(Beam beam, out Section section, out vec3 at, out float density) {
    if (beam.medium != point.medium) return false;
    count(TALLY_TESTS);
    Covered covered;
    if (!covers(beam, footprint, covered)) return false;
    vec3 w = covered.weights;
    section.weights = w;
    section.y = dot(w, covered.heights);
    section.way = w.x * beam.corners[0].way + w.y * beam.corners[1].way + w.z * beam.corners[2].way;
    section.area = section_area(beam, section.y);
    at = w.x * (beam.corners[0].origin + covered.heights.x * beam.corners[0].way) +
         w.y * (beam.corners[1].origin + covered.heights.y * beam.corners[1].way) +
         w.z * (beam.corners[2].origin + covered.heights.z * beam.corners[2].way);
    density = density_on_area(section, covered.part / footprint.area, shading, geometric);
    return section.y <= beam_range(beam).y;
}

void visit(uint bases[2], uvec2 near_beams) {
    uint lane = gl_LocalInvocationIndex;
    uint own = lane / 32u == 0u ? near_beams.x : near_beams.y;
    if ((own >> (lane % 32u) & 1u) != 0u) {
        Beam beam = beams[bases[lane / BLOCK_BEAMS] + lane % BLOCK_BEAMS];
        // The bound is the device's to read: unrolled, this loop took lavapipe half a minute to compile.
        for (uint part = 0u; part < push.parts; part++) {
            if (comes_near(beam, part_box(part))) atomicOr(part_beams[part][lane / 32u], 1u << (lane % 32u));
        }
    }
    barrier();
    uvec2 mine = uvec2(part_beams[lane / PARTS][0], part_beams[lane / PARTS][1]);
    barrier();
    if (lane < PARTS) part_beams[lane] = uint[2](0u, 0u);
    while (any_bit(mine)) {
        uint bit = take_bit(mine);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
        if (!here) continue;
        Section section;
        vec3 at = point.position;
        vec3 start;
        float density;
        // Both ways meet again before the expensive part, so that it is compiled once.
        if (footprint.known) {
            if (!meets_footprint(beam, section, at, density)) continue;
        } else {
            if (!holds_point(beam, point, section)) continue;
            density = density_at_point(push.shade, beam, section, shading, geometric);
        }
        vec3 light = arriving_light(push.shade, beam, section, at, density, start);
        // Shadows are the point's: beside an edge, what the pixel covers of the surface's plane can lie behind another.
        sum += unshadowed(push.shade, beam, section, point.position, start, light);
    }
}

// The step to a neighbour that is on the same surface.
bool step_to(uint slot, out vec3 step) {
    VisiblePoint other = visible_points[slot];
    step = other.position - point.position;
    return other.instance == point.instance && other.medium == point.medium &&
           dot(unpack_direction(other.geometric), geometric) > 0.9;
}

void look_around(uint slot) {
    footprint.known = false;
    if (push.footprints == 0u || !here) return;
    uint place = slot % (view.width * view.rows);
    uint x = place % view.width;
    uint y = place / view.width;
    vec3 left = vec3(0.0), right = vec3(0.0), above = vec3(0.0), below = vec3(0.0);
    bool has_left = x > 0u && step_to(slot - 1u, left);
    bool has_right = x + 1u < view.width && step_to(slot + 1u, right);
    bool has_above = y > 0u && step_to(slot - view.width, above);
    bool has_below = y + 1u < view.rows && step_to(slot + view.width, below);
    vec3 across, down;
    bool known = pixel_step(has_left, -left, has_right, right, across);
    known = pixel_step(has_above, -above, has_below, below, down) && known;
    if (known) footprint = footprint_of(point.position, geometric, across, down, push.jitter);
}

Box own_box() {
    if (!footprint.known) return Box(point.position, point.position);
    // Back from pixels to metres.
    float scale = dot(footprint.normal, cross(footprint.across, footprint.down));
    vec3 across = cross(footprint.down, footprint.normal) / scale;
    vec3 down = cross(footprint.normal, footprint.across) / scale;
    vec3 middle = point.position + footprint.centre.x * across + footprint.centre.y * down;
    vec3 extent = 0.5 * (abs(across) + abs(down));
    return Box(middle - extent, middle + extent);
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
    look_around(slot);
    // Points that the camera sees straight are lit already.
    bool drawn = push.tile.drawn != 0u && slot < view.width * view.rows;
    if (drawn && here && visible_shades[slot].events == 0u) here = false;
    uint media = find_boxes(own_box());
    if (drawn) {
        sum = drawn_irradiance[slot].rgb;
        count_drawn(drawn_irradiance[slot].w);
    }
    traverse(push.tile, media);
    if (slot != NO_SLOT) sample_irradiance[slot] = vec4(sum, 0.0);
    close_tallies();
}
