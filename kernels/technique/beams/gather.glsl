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
shared uint bounds[PARTS + 1u][6]; // of each part, low, then high; after them the tile's
// Bits of the beams that come near a part. Three that take turns, as votes do.
shared uint part_beams[3][PARTS][2];
uint part_turn = 0u;
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

// Of a part, or of the tile after them.
Box box_of(uint part) {
    Box found;
    for (uint i = 0u; i < 3u; i++) {
        found.low[i] = from_ordered(bounds[part][i]);
        found.high[i] = from_ordered(bounds[part][3u + i]);
    }
    return found;
}

// Opens boxes round what this invocation looks at.
uint find_boxes(Box own) {
    uint lane = gl_LocalInvocationIndex;
    if (lane < 6u * PARTS) bounds[lane / 6u][lane % 6u] = lane % 6u < 3u ? 0xffffffffu : 0u;
    if (lane < 6u * PARTS) part_beams[lane / (2u * PARTS)][lane / 2u % PARTS][lane % 2u] = 0u;
    if (lane == 0u) tile_media = 0u;
    open_tallies();
    open_votes();
    barrier();
    if (here) {
        for (uint i = 0u; i < 3u; i++) {
            atomicMin(bounds[lane / PARTS][i], ordered(own.low[i]));
            atomicMax(bounds[lane / PARTS][3u + i], ordered(own.high[i]));
        }
        atomicOr(tile_media, medium_bit(point.medium));
    }
    barrier();
    // A part without points has bounds that hold nothing, and takes none from the others.
    if (lane < 6u) {
        uint found = bounds[0][lane];
        for (uint part = 1u; part < push.parts; part++) {
            uint other = bounds[part][lane];
            found = lane < 3u ? min(found, other) : max(found, other);
        }
        bounds[PARTS][lane] = found;
    }
    barrier();
    box = box_of(PARTS);
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
bool comes_near(Beam beam, vec2 range, Box other) {
    vec3 middle = 0.5 * (other.low + other.high) - beam.corners[0].origin;
    float y = dot(beam.normal, middle);
    float extent = dot(abs(beam.normal), 0.5 * (other.high - other.low));
    extent += 1e-5 * (abs(y) + extent);
    range = vec2(max(range.x, y - extent), min(range.y, y + extent));
    if (!(range.x <= range.y)) return false;
    vec3 low, high;
    box_of_range(beam, range, low, high);
    return meet(low, high, other);
}

// Held against the tile, and then against its parts, in one loop whose bound is the device's to read: unrolled, it took
// lavapipe half a minute to compile.
bool near_beam(Beam beam) {
    uint lane = gl_LocalInvocationIndex;
    vec2 range = beam_range(beam);
    bool near = true;
    for (uint k = 0u; near && k <= push.parts; k++) {
        uint part = (k + PARTS) % (PARTS + 1u);
        bool meets = comes_near(beam, range, box_of(part));
        if (k == 0u) near = meets;
        else if (meets) atomicOr(part_beams[part_turn][part][lane / 32u], 1u << (lane % 32u));
    }
    return near;
}

// Whether the beam may light what this invocation looks at: next to nothing is left out that does. Software drivers run
// both ways of every branch, so that this, and no more, is what beams cost that pass by.
bool may_light(Beam beam) {
    if (beam.medium != point.medium) return false;
    count(TALLY_TESTS);
    vec2 at[3];
    vec3 heights;
    return footprint.known ? meets_pixel(beam, footprint, at, heights)
                           : comes_near(beam, beam_range(beam), Box(point.position, point.position));
}

// Where the beam's light that falls into the pixel arrives, and how much of it, 1/m2.
bool meets_footprint(Beam beam, out Section section, out vec3 at, out float density) {
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

// In stored order.
void visit(uint bases[2], uvec2 near_beams) {
    uint lane = gl_LocalInvocationIndex;
    uint part = lane / PARTS;
    uvec2 mine = uvec2(part_beams[part_turn][part][0], part_beams[part_turn][part][1]);
    // The turn before was read by all before the vote that led here.
    uint last = (part_turn + 2u) % 3u;
    part_turn = (part_turn + 1u) % 3u;
    if (lane < 2u * PARTS) part_beams[last][lane / 2u][lane % 2u] = 0u;
    if (!here) mine = uvec2(0u);
    uvec2 met = uvec2(0u);
    while (any_bit(mine)) {
        uint bit = take_bit(mine);
        if (may_light(beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS])) met[bit / 32u] |= 1u << (bit % 32u);
    }
    while (any_bit(met)) {
        uint bit = take_bit(met);
        Beam beam = beams[bases[bit / BLOCK_BEAMS] + bit % BLOCK_BEAMS];
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
    uint tile = own_tile(push.tile);
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
