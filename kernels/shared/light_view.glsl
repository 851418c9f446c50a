// What a light sees: frusta and boxes, and a lattice of texels over each, in two layers. renderer/light_view.rs makes them.
// Kernels declare the blocks themselves: LightViews { LightView light_views[]; }, LightTexels { LightTexel light_texels[]; }.
#include "shared/optics.glsl"

struct LightView {
    vec3 origin;      // point, spot: the light's position; directional: on a plane upstream of the scene
    uint light;
    vec3 right;       // unit, as the next two; right x up = forward
    uint columns;     // texels along right
    vec3 up;
    uint rows;        // texels along up
    vec3 forward;     // the way the light goes
    uint first_texel; // of the view's first layer
    vec2 lower;       // the part of the chart that specular objects fill
    vec2 upper;
    uint perspective; // 1: directions forward + u right + v up; 0: parallel, u and v in metres
    float reach;      // metres: nothing of the scene is farther from the light, or from the plane
    uint padding0;
    uint padding1;
};

struct LightTexel { // what the ray through a point of the lattice meets first in its layer
    vec3 position;
    float depth;       // metres from the ray's origin
    uint normal;       // packed, shading, of the front side
    uint geometric;    // packed, of the front side
    uint material;
    uint instance;     // NO_INSTANCE: nothing is met, and the rest is zero
    vec2 barycentrics; // weights of the triangle's second and third vertex
    uint primitive;
    uint padding0;
};

const uint LIGHT_SPECULAR = 0u; // layers
const uint LIGHT_OPAQUE = 1u;
const uint LIGHT_LAYERS = 2u;

// Texels lie on the lattice from the rectangle's lower to its upper corner, both included.
uint light_texel_index(LightView v, uint layer, uvec2 texel) {
    return v.first_texel + (layer * v.rows + texel.y) * v.columns + texel.x;
}

// `place` in [0, 1]^2 over the rectangle.
vec2 chart_at(LightView v, vec2 place) {
    return v.lower + (v.upper - v.lower) * place;
}

vec2 light_texel_place(LightView v, uvec2 texel) {
    return vec2(texel) / vec2(v.columns - 1u, v.rows - 1u);
}

// `direction` is unit.
void light_ray(LightView v, vec2 at, out vec3 origin, out vec3 direction) {
    vec3 across = at.x * v.right + at.y * v.up;
    bool perspective = v.perspective != 0u;
    origin = perspective ? v.origin : v.origin + across;
    direction = perspective ? normalize(v.forward + across) : v.forward;
}

// sr per unit of the chart's area; parallel: m2 per m2.
float chart_density(LightView v, vec2 at) {
    if (v.perspective == 0u) return 1.0;
    float length2 = 1.0 + dot(at, at);
    return 1.0 / (length2 * sqrt(length2));
}

// W per unit of the chart's area, before anything is met.
vec3 light_power(LightView v, Light light, vec2 at) {
    vec3 direction = normalize(v.forward + at.x * v.right + at.y * v.up); // of no account where it is parallel
    return light_power_along(light, direction) * chart_density(v, at);
}

// Whether the light reaches the specular surface past everything opaque.
bool lit_specular(LightTexel specular, LightTexel opaque) {
    return specular.instance != NO_INSTANCE && (opaque.instance == NO_INSTANCE || specular.depth < opaque.depth);
}
