// Follows a ray over the texels of a view until it meets what is seen there. Hierarchical: nodes of the pyramid that the
// ray passes in front of, or wholly behind, are crossed in one step; what a texel decides is the same in both ways.
#include "technique/photons/spaces.glsl"

// What ended a march.
const uint TRAIL_HIT = 0u;
const uint TRAIL_LEFT = 1u;   // over the view's border, or it never was inside
const uint TRAIL_HIDDEN = 2u; // behind what is seen, where the view knows nothing, and told to stop there
const uint TRAIL_LONG = 3u;   // more steps than are taken

struct Trail {
    uint end;
    float t;       // m from the origin, where it ended
    uvec2 texel;   // that was hit
    SeenPlane plane;
    uint steps;
    bool was_hidden; // somewhere on the way it was behind what is seen
};

struct MarchSettings {
    bool hierarchical;
    bool linear_end;    // Eq. 2 of the paper instead of the triangle's plane
    bool stops_hidden;
    uint max_steps;
};

// Metres along the ray to where its place crosses texel line `line`, which lies ahead in the picture. A ray comes nearer
// and nearer to where it vanishes: what lies beyond it never crosses.
float crossing(float line, bool up, float from, float from_w, float way, float way_w) {
    float change = way - line * way_w;
    if (up ? change <= 0.0 : change >= 0.0) return NOTHING;
    return (line * from_w - from) / change;
}

// Narrows `range` to where a + t b >= 0.
void keep_positive(float a, float b, inout vec2 range) {
    if (b == 0.0) {
        if (a < 0.0) range.y = -1.0;
        return;
    }
    float t = -a / b;
    if (b > 0.0) range.x = max(range.x, t);
    else range.y = min(range.y, t);
}

// The part of a ray that lies in the view, m.
vec2 part_inside(LightView v, vec4 from, vec4 way, vec2 range) {
    keep_positive(from.w - NEAREST, way.w, range);
    keep_positive(from.x, way.x, range);
    keep_positive(from.y, way.y, range);
    keep_positive(float(v.columns) * from.z - from.x, float(v.columns) * way.z - way.x, range);
    keep_positive(float(v.rows) * from.z - from.y, float(v.rows) * way.z - way.y, range);
    return range;
}

vec2 texels_at(vec4 from, vec4 way, float t) {
    return (from.xy + t * way.xy) / (from.z + t * way.z);
}

uint pyramid_top(LightView v) {
    return uint(findMSB(max(max(v.columns, v.rows), 2u) - 1u)) + 1u;
}

// Where the ray's depth meets what is seen, both taken to be linear from one texel to the next (Eq. 2): the ray was
// over the one before at `t_before` and leaves this one, where `seen` is the depth, at `t_after`. `otherwise` where the
// one before sees nothing.
float linear_end(LightView v, vec4 from, vec4 way, float t_before, float t_after, float seen, float otherwise) {
    vec2 at = texels_at(from, way, t_before);
    if (any(lessThan(at, vec2(0.0))) || any(greaterThanEqual(at, vec2(v.columns, v.rows)))) return otherwise;
    uvec2 texel = uvec2(at);
    uvec2 ids = opaque_ids[id_index(v, texel)];
    if (ids.x == 0u) return otherwise;
    float seen_before = plane_depth(v, plane_of(v, ids), chart_of(v, texel));
    float change = (t_after - t_before) * way.w - (seen - seen_before);
    float u = abs(change) > 1e-20 ? (seen_before - from.w - t_before * way.w) / change : 0.0;
    return mix(t_before, t_after, clamp(u, 0.0, 1.0));
}

// From `origin` + `start` `direction` on.
Trail march(LightView v, uint view_index, vec3 origin, vec3 direction, float start, MarchSettings how) {
    Trail result = Trail(TRAIL_LEFT, start, uvec2(0u), SeenPlane(vec3(0.0), vec3(0.0)), 0u, false);
    vec4 from = place_of(v, origin - v.origin);
    vec4 way = place_along(v, direction);
    vec2 range = part_inside(v, from, way, vec2(start, NOTHING));
    if (!(range.x < range.y)) return result;
    // The sign of a place's change is the same all along the ray.
    vec2 turn = way.xy * from.z - from.xy * way.z;
    bvec2 up = greaterThan(turn, vec2(0.0));
    ivec2 size = ivec2(v.columns, v.rows);
    float t = range.x;
    ivec2 cell = clamp(ivec2(floor(texels_at(from, way, t))), ivec2(0), size - 1);
    uint top = how.hierarchical ? pyramid_top(v) : 0u;
    uint level = min(top, 2u);

    for (uint i = 0u; i < how.max_steps; i++) {
        result.steps++;
        ivec2 node = cell >> int(level);
        ivec2 low = node << int(level);
        ivec2 high = low + (1 << int(level));
        float tx = turn.x == 0.0 ? NOTHING : crossing(float(up.x ? high.x : low.x), up.x, from.x, from.z, way.x, way.z);
        float ty = turn.y == 0.0 ? NOTHING : crossing(float(up.y ? high.y : low.y), up.y, from.y, from.z, way.y, way.z);
        float t_out = max(min(min(tx, ty), range.y), t);
        float z_in = from.w + t * way.w;
        float z_out = from.w + t_out * way.w;
        vec2 slab = depth_slabs[slab_index(v, view_index, level, uvec2(node))];
        bool before = max(z_in, z_out) < slab.x;
        bool behind = min(z_in, z_out) > slab.y;
        if (!before && !behind && level > 0u) {
            level--;
            continue;
        }
        if (behind) {
            result.was_hidden = true;
            if (how.stops_hidden) {
                result.end = TRAIL_HIDDEN;
                result.t = t;
                return result;
            }
        }
        if (!before && !behind) {
            SeenPlane plane = plane_of(v, opaque_ids[id_index(v, uvec2(cell))]);
            float slope = dot(plane.normal, direction);
            if (slope <= 0.0) {
                float end = dot(plane.normal, plane.point - origin) / min(slope, -1e-9);
                float seen = plane_depth(v, plane, chart_of(v, uvec2(cell)));
                // A ray that is still before the plane when it leaves the texel has not met it there.
                float slack = t_out - t;
                if (how.linear_end) end = linear_end(v, from, way, t - slack, t_out, seen, end);
                if (end <= t_out + slack) {
                    result.end = TRAIL_HIT;
                    result.t = clamp(end, max(t - slack, start), t_out + slack);
                    result.texel = uvec2(cell);
                    result.plane = plane;
                    return result;
                }
            }
        }
        result.t = t_out;
        if (t_out >= range.y) return result;
        vec2 at = texels_at(from, way, t_out);
        if (tx <= ty) {
            cell.x = up.x ? high.x : low.x - 1;
            cell.y = clamp(int(floor(at.y)), low.y, min(high.y, size.y) - 1);
        } else {
            cell.y = up.y ? high.y : low.y - 1;
            cell.x = clamp(int(floor(at.x)), low.x, min(high.x, size.x) - 1);
        }
        if (any(lessThan(cell, ivec2(0))) || any(greaterThanEqual(cell, size))) return result;
        t = t_out;
        level = min(level + 1u, top);
    }
    result.end = TRAIL_LONG;
    return result;
}
