// What a pixel covers of the surface around its visible point, and which part of a beam's light falls there. Light that
// focuses to a line is thinner than any pixel: points see it or miss it, areas do neither.
#include "technique/beams/section.glsl"

struct Footprint {
    bool known;   // false: the pixel's neighbours do not tell, and its point has to do
    vec3 point;   // m
    vec3 normal;  // of the face, on the side that is seen
    vec3 across;  // 1/m: pixels to the right, from `point`
    vec3 down;    // 1/m: pixels down
    vec2 centre;  // of the pixel, in these pixels
    float area;   // m2
};

// Of two steps to neighbours, the longer over the shorter: beyond, the surface is not what one sees between them.
const float MOST_UNEVEN = 3.0;

// The mean of the steps from the pixels on both sides, or the one there is.
bool pixel_step(bool has_before, vec3 before, bool has_after, vec3 after, out vec3 step) {
    step = has_before && has_after ? 0.5 * (before + after) : has_before ? before : after;
    if (!has_before || !has_after) return has_before || has_after;
    float a = dot(before, before);
    float b = dot(after, after);
    return max(a, b) <= MOST_UNEVEN * MOST_UNEVEN * min(a, b) && dot(before, after) > 0.0;
}

// `across` and `down`: steps from pixel to pixel, m.
Footprint footprint_of(vec3 point, vec3 normal, vec3 across, vec3 down, vec2 jitter) {
    Footprint f;
    f.point = point;
    f.normal = normal;
    across -= dot(across, normal) * normal;
    down -= dot(down, normal) * normal;
    float area = dot(normal, cross(across, down));
    f.area = abs(area);
    f.known = f.area > 1e-3 * length(across) * length(down) && f.area > 1e-20;
    f.across = cross(down, normal) / area;
    f.down = cross(normal, across) / area;
    f.centre = 0.5 - jitter;
    return f;
}

// Area between an edge and the pixel's lower side, as far as the pixel goes; signed by the edge's way.
float area_under(vec2 a, vec2 b) {
    float run = b.x - a.x;
    float from = clamp(a.x, -0.5, 0.5);
    float to = clamp(b.x, -0.5, 0.5);
    if (from == to) return 0.0;
    float slope = (b.y - a.y) / run;
    float low = a.y + (from - a.x) * slope;
    float high = a.y + (to - a.x) * slope;
    float rise = high - low;
    float mean_height = abs(rise) > 1e-4 ? (clamped_integral(high + 0.5) - clamped_integral(low + 0.5)) / rise
                                         : clamp(0.5 * (low + high), -0.5, 0.5) + 0.5;
    return (to - from) * mean_height;
}

// Part of a segment that lies in the pixel.
float length_inside(vec2 a, vec2 b) {
    vec2 way = b - a;
    vec2 safe = mix(way, vec2(1e-20), lessThan(abs(way), vec2(1e-20)));
    vec2 t0 = (-0.5 - a) / safe;
    vec2 t1 = (0.5 - a) / safe;
    vec2 enter = min(t0, t1);
    vec2 leave = max(t0, t1);
    return max(min(min(leave.x, leave.y), 1.0) - max(max(enter.x, enter.y), 0.0), 0.0);
}

// Square pixels below which a beam's triangle is taken for its longest side.
const float THIN = 1e-4;

struct Covered {
    float part;   // of the beam's light
    vec3 weights; // barycentrics of the middle of what is covered, about
    vec3 heights; // y of the edges where they meet the surface's plane
};

// Where the edges meet the surface's plane, in pixels from the pixel's middle, and at which y; false where a box round
// these places keeps clear of the pixel.
bool meets_pixel(Beam beam, Footprint f, out vec2 at[3], out vec3 heights) {
    for (uint i = 0u; i < 3u; i++) {
        BeamCorner corner = beam.corners[i];
        vec3 from = f.point - corner.origin;
        float cosine = dot(f.normal, corner.way);
        // Along the surface, or out of it.
        if (cosine > -1e-3) return false;
        float y = dot(f.normal, from) / cosine;
        vec3 to = y * corner.way - from;
        at[i] = vec2(dot(to, f.across), dot(to, f.down)) - f.centre;
        heights[i] = y;
    }
    vec2 low = min(at[0], min(at[1], at[2]));
    vec2 high = max(at[0], max(at[1], at[2]));
    return all(lessThanEqual(low, vec2(0.5))) && all(greaterThanEqual(high, vec2(-0.5)));
}

// False where none of the beam's light falls into the pixel.
bool covers(Beam beam, Footprint f, out Covered covered) {
    vec2 at[3];
    if (!meets_pixel(beam, f, at, covered.heights)) return false;
    vec2 ab = at[1] - at[0];
    vec2 ac = at[2] - at[0];
    float whole = 0.5 * (ab.x * ac.y - ab.y * ac.x);
    if (abs(whole) < THIN) {
        vec2 bc = at[2] - at[1];
        float longest = max(dot(ab, ab), max(dot(ac, ac), dot(bc, bc)));
        covered.weights = vec3(1.0 / 3.0);
        covered.part = dot(ab, ab) == longest ? length_inside(at[0], at[1])
                     : dot(ac, ac) == longest ? length_inside(at[0], at[2]) : length_inside(at[1], at[2]);
        return covered.part > 0.0;
    }
    float inside = -(area_under(at[0], at[1]) + area_under(at[1], at[2]) + area_under(at[2], at[0]));
    covered.part = clamp(inside / whole, 0.0, 1.0);
    // The pixel's middle, brought into the triangle.
    vec3 weights = max(vec3(at[1].x * at[2].y - at[1].y * at[2].x, at[2].x * at[0].y - at[2].y * at[0].x,
                            at[0].x * at[1].y - at[0].y * at[1].x) / whole, vec3(0.0));
    covered.weights = weights / (weights.x + weights.y + weights.z);
    return covered.part > 0.0;
}
