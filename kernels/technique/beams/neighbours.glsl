// Which slots see one surface, so that light may be spread between them. Whatever is asked here of two, they answer alike:
// what one gives, the other gets.
#include "shared/scene.glsl"
#include "shared/math.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };

// Of two normals: farther apart, there is an edge.
const float LEAST_COSINE = 0.9;

// Of a pixel's width: what a point may lie off another's plane beside what the surface bends.
const float MOST_STEP = 0.5;

struct Site {
    vec3 position;
    vec3 normal; // of the face
    uint instance;
    uint medium;
};

Site site_at(uint slot) {
    VisiblePoint point = visible_points[slot];
    return Site(point.position, unpack_direction(point.geometric), point.instance, point.medium);
}

// `width`: about that of a pixel there, m.
bool on_one_surface(Site a, Site b, float width) {
    if (a.instance == NO_INSTANCE || a.instance != b.instance || a.medium != b.medium) return false;
    if (dot(a.normal, b.normal) < LEAST_COSINE) return false;
    vec3 way = b.position - a.position;
    float off = max(abs(dot(a.normal, way)), abs(dot(b.normal, way)));
    // Between faces that differ by an angle, no point is farther off than its sine.
    return off <= length(a.normal - b.normal) * length(way) + MOST_STEP * width;
}
