// Where what is seen at a pixel's centre was a frame before, and where the camera of that time saw it.
#include "shared/scene.glsl"
#include "shared/view.glsl"
#include "trace/interface.glsl"

layout(set = 3, binding = 0, std430) readonly buffer PreviousVertices { Vertex previous_vertices[]; };
layout(set = 3, binding = 1, std430) readonly buffer PreviousInstances { Instance previous_instances[]; };
layout(set = 3, binding = 2, std430) readonly buffer PreviousViews { View previous_view; };

struct Motion {
    vec2 moved;      // pixels, +x right, +y down, from its place in the picture before
    bool was_before; // whether it was before that camera; else `moved` says nothing
    uint instance;   // NO_INSTANCE: the background
    float distance;  // m from the camera; 1 where the background is seen
    float then;      // the same a frame before
};

// Pixels from the picture's upper left corner. `along` is the component on the viewing direction.
vec2 place_in(View camera, vec3 way, out float along) {
    precise float ahead = dot(way, camera.forward);
    precise vec2 at = vec2(dot(way, camera.right) / dot(camera.right, camera.right),
                           -dot(way, camera.up) / dot(camera.up, camera.up));
    precise vec2 place = (0.5 * at / ahead + 0.5) * vec2(camera.width, camera.height);
    along = ahead;
    return place;
}

// Whether a place in the picture is finite.
bool in_front(float along, vec3 way) {
    return along > 1e-6 * length(way);
}

vec3 point_of(vec3 a, vec3 b, vec3 c, vec2 barycentrics) {
    precise vec3 point = a * (1.0 - barycentrics.x - barycentrics.y) + b * barycentrics.x + c * barycentrics.y;
    return point;
}

vec3 placed(vec4 to_world[3], vec3 point) {
    precise vec3 place = vec3(dot(to_world[0].xyz, point) + to_world[0].w, dot(to_world[1].xyz, point) + to_world[1].w,
                              dot(to_world[2].xyz, point) + to_world[2].w);
    return place;
}

// Of the first surface, water included, through the centre of a pixel of the band.
Motion motion_of(uint pixel) {
    vec3 direction = pixel_direction(uvec2(pixel % view.width, pixel / view.width), vec2(0.5));
    Hit hit = trace_closest(Ray(view.position, 0.0, direction, 1e30), MASK_ALL);
    // The background is infinitely far: cameras that turn move it, cameras that travel do not.
    precise vec3 now = direction;
    precise vec3 before = direction;
    Motion m = Motion(vec2(0.0), false, hit.instance, 1.0, 1.0);
    if (hit.instance != NO_INSTANCE) {
        Instance instance = instances[hit.instance];
        Instance was = previous_instances[hit.instance];
        uvec3 corner = triangle_vertices(instance, hit.primitive);
        vec3 point = point_of(vertices[corner.x].position, vertices[corner.y].position, vertices[corner.z].position,
                              hit.barycentrics);
        vec3 point_before = point_of(previous_vertices[corner.x].position, previous_vertices[corner.y].position,
                                     previous_vertices[corner.z].position, hit.barycentrics);
        now = placed(instance.to_world, point) - view.position;
        before = placed(was.to_world, point_before) - previous_view.position;
        m.distance = length(now);
        m.then = length(before);
    }
    // Both by one formula, every operation of it as it is written, so that what stands still has no motion at all.
    float along_now;
    float along_before;
    vec2 at = place_in(view, now, along_now);
    vec2 was_at = place_in(previous_view, before, along_before);
    m.was_before = in_front(along_now, now) && in_front(along_before, before);
    precise vec2 moved = at - was_at;
    m.moved = moved;
    return m;
}
