// The shaft round the view rays of a tile, and what meets it.
#include "shared/segments.glsl"
#include "technique/beams/ordered.glsl"
#include "technique/beams/section.glsl"
#include "technique/beams/shaft.glsl"

shared uint shaft_numbers[10];
shared int shaft_sum[3];
shared uint shaft_media;

// Directions are added up as integers: in whatever order, the sum is the same.
const float SUM_UNIT = 1048576.0;

void widen(uint low_index, float value) {
    atomicMin(shaft_numbers[low_index], ordered(value));
    atomicMax(shaft_numbers[low_index + 1u], ordered(value));
}

// Round the stretches of all invocations that have one, with the bits of their media; in uniform control flow.
Shaft shaft_round(Stretch s, out uint found_media) {
    uint lane = gl_LocalInvocationIndex;
    bool here = s.medium != NO_MEDIUM;
    barrier(); // what the shaft before was made from is read
    if (lane < 10u) shaft_numbers[lane] = (lane & 1u) == 0u ? 0xffffffffu : 0u;
    if (lane < 3u) shaft_sum[lane] = 0;
    if (lane == 0u) shaft_media = 0u;
    barrier();
    if (here) {
        for (uint i = 0u; i < 3u; i++) atomicAdd(shaft_sum[i], int(round(s.direction[i] * SUM_UNIT)));
        atomicOr(shaft_media, medium_bit(s.medium));
    }
    barrier();
    found_media = shaft_media;
    Shaft shaft;
    vec3 total = vec3(shaft_sum[0], shaft_sum[1], shaft_sum[2]);
    float size = length(total);
    shaft.axis = size > 0.0 ? total / size : vec3(0.0, 0.0, 1.0);
    basis(shaft.axis, shaft.across[0], shaft.across[1]);
    vec3 end = s.origin + s.extent * s.direction;
    if (here) {
        widen(0u, dot(s.origin, shaft.axis));
        widen(0u, dot(end, shaft.axis));
    }
    // Whether one is far off the mean: any bit of the last number's place.
    bool off = here && dot(s.direction, shaft.axis) < LEAST_COSINE;
    bool parallel = any_bit(vote(off));
    shaft.ends = vec2(from_ordered(shaft_numbers[0]), from_ordered(shaft_numbers[1]));
    if (here) {
        for (uint i = 0u; i < 2u; i++) {
            float first = dot(s.origin, shaft.across[i]);
            float last = dot(end, shaft.across[i]);
            float along = dot(s.direction, shaft.axis);
            float slope = parallel ? 0.0 : dot(s.direction, shaft.across[i]) / along;
            float start = dot(s.origin, shaft.axis);
            widen(2u + 2u * i, first + slope * (shaft.ends.x - start));
            widen(6u + 2u * i, first + slope * (shaft.ends.y - start));
            if (parallel) {
                widen(2u + 2u * i, last);
                widen(6u + 2u * i, last);
            }
        }
    }
    barrier();
    for (uint i = 0u; i < 4u; i++) {
        shaft.at_near[i] = from_ordered(shaft_numbers[2u + i]);
        shaft.at_far[i] = from_ordered(shaft_numbers[6u + i]);
    }
    add_slack(shaft);
    return shaft;
}

// A plane of the shaft, 0 to 3: xyz and w so that dot(xyz, point) > w is outside.
vec4 side_plane(Shaft shaft, uint index) {
    uint axis = index / 2u;
    float turn = (index & 1u) == 0u ? -1.0 : 1.0;
    float slope = (shaft.at_far[index] - shaft.at_near[index]) / max(shaft.ends.y - shaft.ends.x, 1e-20);
    vec3 normal = shaft.across[axis] - slope * shaft.axis;
    return turn * vec4(normal, shaft.at_near[index] - slope * shaft.ends.x);
}

bool box_meets_shaft(vec3 low, vec3 high, Shaft shaft) {
    vec3 middle = 0.5 * (low + high);
    vec3 extent = 0.5 * (high - low);
    float at = dot(middle, shaft.axis);
    float size = dot(extent, abs(shaft.axis));
    bool meets = at - size <= shaft.ends.y && at + size >= shaft.ends.x;
    for (uint i = 0u; i < 4u; i++) {
        vec4 plane = side_plane(shaft, i);
        meets = meets && dot(plane.xyz, middle) - dot(extent, abs(plane.xyz)) <= plane.w;
    }
    return meets;
}

// Whether no plane of the shaft, and none along one of its edges and `way`, has the points' hull and the shaft on different
// sides.
bool hull_meets_shaft(vec3 points[8], vec3 way, Shaft shaft) {
    vec2 along = vec2(3e38, -3e38);
    vec4 outside = vec4(3e38);
    for (uint i = 0u; i < 8u; i++) {
        float at = dot(points[i], shaft.axis);
        along = vec2(min(along.x, at), max(along.y, at));
    }
    for (uint p = 0u; p < 4u; p++) {
        vec4 plane = side_plane(shaft, p);
        for (uint i = 0u; i < 8u; i++) outside[p] = min(outside[p], dot(plane.xyz, points[i]) - plane.w);
    }
    if (along.x > shaft.ends.y || along.y < shaft.ends.x || any(greaterThan(outside, vec4(0.0)))) return false;
    for (uint edge = 0u; edge < 4u; edge++) {
        vec3 corner = shaft_corner(shaft, edge, shaft.ends.x);
        vec3 normal = cross(shaft_corner(shaft, edge, shaft.ends.y) - corner, way);
        // From the edge: both sides of the plane, of the points and of the shaft.
        vec2 of_points = vec2(3e38, -3e38);
        vec2 of_shaft = vec2(0.0);
        for (uint i = 0u; i < 8u; i++) {
            float at = dot(normal, points[i] - corner);
            of_points = vec2(min(of_points.x, at), max(of_points.y, at));
            float own = dot(normal, shaft_corner(shaft, i & 3u, i < 4u ? shaft.ends.x : shaft.ends.y) - corner);
            of_shaft = vec2(min(of_shaft.x, own), max(of_shaft.y, own));
        }
        float slack = 1e-5 * (of_shaft.y - of_shaft.x + of_points.y - of_points.x);
        if (of_points.x > of_shaft.y + slack || of_points.y < of_shaft.x - slack) return false;
    }
    return true;
}

bool beam_meets_shaft(Beam beam, Shaft shaft) {
    vec2 range = beam_range(beam);
    vec3 points[8];
    for (uint i = 0u; i < 8u; i++) {
        BeamCorner corner = beam.corners[min(i % 4u, 2u)];
        points[i] = corner.origin + (i < 4u ? range.x : range.y) * corner.way;
    }
    return hull_meets_shaft(points, beam.corners[0].way + beam.corners[1].way + beam.corners[2].way, shaft);
}

bool shafts_meet(Shaft other, Shaft shaft) {
    vec3 points[8];
    for (uint i = 0u; i < 8u; i++) points[i] = shaft_corner(other, i & 3u, i < 4u ? other.ends.x : other.ends.y);
    return hull_meets_shaft(points, other.axis, shaft);
}
