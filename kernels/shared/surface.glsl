// From a hit to what is there.
#include "shared/math.glsl"
#include "shared/scene.glsl"

struct Surface {
    vec3 position;  // world space
    vec3 geometric; // unit normal of the front side, world space
    vec3 shading;   // unit, interpolated, on the side of `geometric`
    vec2 uv;
    uint material;
    float reach;    // largest coordinate of the triangle's corners, m: what its rounding goes by
};

Surface surface_at(uint instance_id, uint primitive, vec2 barycentrics) {
    Instance instance = instances[instance_id];
    uvec3 corner = triangle_vertices(instance, primitive);
    Vertex a = vertices[corner.x];
    Vertex b = vertices[corner.y];
    Vertex c = vertices[corner.z];
    vec3 weight = vec3(1.0 - barycentrics.x - barycentrics.y, barycentrics);
    vec3 pa = transform_point(instance.to_world, a.position);
    vec3 pb = transform_point(instance.to_world, b.position);
    vec3 pc = transform_point(instance.to_world, c.position);

    Surface s;
    s.position = pa * weight.x + pb * weight.y + pc * weight.z;
    s.geometric = normalize(cross(pb - pa, pc - pa));
    if (instance.mirrored != 0u) s.geometric = -s.geometric;
    vec3 normal = a.normal * weight.x + b.normal * weight.y + c.normal * weight.z;
    vec3 world = transform_normal(instance.to_object, normal);
    float size = length(world);
    // Opposite normals at the corners can cancel; the face's own normal is then the best answer.
    s.shading = size > 1e-12 ? world / size : s.geometric;
    if (dot(s.shading, s.geometric) < 0.0) s.shading = -s.shading;
    s.uv = vec2(a.u, a.v) * weight.x + vec2(b.u, b.v) * weight.y + vec2(c.u, c.v) * weight.z;
    s.material = instance.material;
    vec3 reach = max(max(abs(pa), abs(pb)), abs(pc));
    s.reach = max(max(reach.x, reach.y), reach.z);
    return s;
}

vec3 texel(Texture t, uint x, uint y) {
    uint bits = texels[t.first_texel + y * t.width + x];
    vec3 root = vec3(bits & 1023u, (bits >> 10) & 1023u, (bits >> 20) & 1023u) / 1023.0;
    return root * root;
}

vec3 bilinear(Texture t, uvec2 first, uvec2 second, vec2 part) {
    vec3 top = mix(texel(t, first.x, first.y), texel(t, second.x, first.y), part.x);
    vec3 bottom = mix(texel(t, first.x, second.y), texel(t, second.x, second.y), part.x);
    return mix(top, bottom, part.y);
}

// Bilinear, repeating; v = 0 is the image's bottom.
vec3 texture_color(uint index, vec2 uv) {
    Texture t = textures[index];
    vec2 size = vec2(t.width, t.height);
    vec2 at = fract(vec2(uv.x, 1.0 - uv.y)) * size - 0.5;
    vec2 low = floor(at);
    vec2 part = at - low;
    ivec2 wrap = ivec2(t.width, t.height);
    uvec2 first = uvec2((ivec2(low) + wrap) % wrap);
    uvec2 second = uvec2((first.x + 1u) % t.width, (first.y + 1u) % t.height);
    return bilinear(t, first, second, part);
}

// Bilinear, the border's colour beyond the middle of its texels; `at` in [0, 1]^2, (0, 0) the upper left corner.
vec3 image_color(uint index, vec2 at) {
    Texture t = textures[index];
    vec2 last = vec2(t.width - 1u, t.height - 1u);
    vec2 place = clamp(at * (last + 1.0) - 0.5, vec2(0.0), last);
    vec2 low = floor(place);
    return bilinear(t, uvec2(low), uvec2(min(low + 1.0, last)), place - low);
}

vec3 albedo_at(Surface s) {
    Material material = materials[s.material];
    return material.texture == NO_TEXTURE ? material.color : material.color * texture_color(material.texture, s.uv);
}

// Where a ray that leaves the surface on the side of `direction` starts. A hit is good to a few units in the last place of
// the triangle's largest coordinate (2^-24 of it each), however near the origin the hit itself is; thirty of them clear
// the surface.
vec3 leave(Surface s, vec3 direction) {
    float step = 2e-6 * max(s.reach, 1e-3);
    return s.position + s.geometric * (dot(direction, s.geometric) < 0.0 ? -step : step);
}
