// Photons leave a light through cells: patches of directions, or of a plane for directional lights.
// renderer/technique/emission.rs makes them and defines the coordinates.
#include "shared/optics.glsl"

struct EmissionCell {
    vec2 lower;
    vec2 size;
    uint light;
    uint face;
    float offset;
    uint padding0;
};

// A ray through the cell for `random` in [0, 1)^2, and the flux of the whole cell were all of it like this ray, W.
void emit(EmissionCell cell, Light light, vec2 random, out vec3 origin, out vec3 direction, out vec3 flux) {
    vec2 at = cell.lower + cell.size * random;
    float area = cell.size.x * cell.size.y;
    if (light.kind == LIGHT_DIRECTIONAL) {
        vec3 u, v;
        basis(light.direction, u, v);
        origin = at.x * u + at.y * v + cell.offset * light.direction;
        direction = light.direction;
        flux = light.intensity * area;
        return;
    }
    uint axis = cell.face / 2u;
    bool negative = (cell.face & 1u) != 0u;
    uint u_axis = (axis + (negative ? 2u : 1u)) % 3u;
    uint v_axis = (axis + (negative ? 1u : 2u)) % 3u;
    vec3 way = vec3(0.0);
    way[axis] = negative ? -1.0 : 1.0;
    way[u_axis] = at.x;
    way[v_axis] = at.y;
    float length2 = dot(way, way);
    origin = light.position;
    direction = way * inversesqrt(length2);
    flux = light_power_along(light, direction) * area / (length2 * sqrt(length2));
}
