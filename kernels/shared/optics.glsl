// What a ray does at a specular surface. The same for light on its way out and for a camera path on its way back,
// apart from n^2, which callers apply.
#include "shared/surface.glsl"

// Unpolarised Fresnel reflectance; `eta` is the index on the ray's side over the other. 1 at total internal reflection.
float fresnel(float cos_in, float eta) {
    float sin2_out = eta * eta * max(0.0, 1.0 - cos_in * cos_in);
    if (sin2_out >= 1.0) return 1.0;
    float cos_out = sqrt(1.0 - sin2_out);
    float perpendicular = (eta * cos_in - cos_out) / (eta * cos_in + cos_out);
    float parallel = (cos_in - eta * cos_out) / (cos_in + eta * cos_out);
    return 0.5 * (perpendicular * perpendicular + parallel * parallel);
}

struct Interface {
    vec3 normal;   // shading normal on the ray's side, unit
    float cos_in;  // in [0, 1]
    float eta;     // index on the ray's side over the other
    float reflectance;
    uint here;     // medium on the ray's side
    uint beyond;   // medium on the other
};

Interface interface_at(Surface s, vec3 direction) {
    Material material = materials[s.material];
    bool from_front = dot(direction, s.geometric) < 0.0;
    Interface i;
    i.here = from_front ? material.front : material.back;
    i.beyond = from_front ? material.back : material.front;
    i.normal = from_front ? s.shading : -s.shading;
    i.cos_in = -dot(direction, i.normal);
    if (i.cos_in <= 0.0) {
        // The interpolated normal faces away from a ray that arrives at a grazing angle; the face's does not.
        i.normal = from_front ? s.geometric : -s.geometric;
        i.cos_in = -dot(direction, i.normal);
    }
    i.cos_in = clamp(i.cos_in, 0.0, 1.0);
    i.eta = media[i.here].index / media[i.beyond].index;
    i.reflectance = fresnel(i.cos_in, i.eta);
    return i;
}

vec3 reflected(Interface i, vec3 direction) {
    return normalize(direction + 2.0 * i.cos_in * i.normal);
}

// Snell's law; call only where the reflectance is below 1.
vec3 refracted(Interface i, vec3 direction) {
    float cos_out = sqrt(max(0.0, 1.0 - i.eta * i.eta * (1.0 - i.cos_in * i.cos_in)));
    return normalize(i.eta * direction + (i.eta * i.cos_in - cos_out) * i.normal);
}

// Whether a direction that left the surface is on the side it should be on; shading normals can bend it across.
bool stays_on_side(Surface s, vec3 before, vec3 after, bool crosses) {
    bool crossed = (dot(before, s.geometric) < 0.0) == (dot(after, s.geometric) < 0.0);
    return crossed == crosses;
}

// Smith's masking for GGX, one direction; c = cosine to the normal.
float smith(float c, float alpha) {
    float t2 = max(0.0, 1.0 / (c * c) - 1.0);
    return 2.0 / (1.0 + sqrt(1.0 + alpha * alpha * t2));
}

// A mirror direction about a microfacet normal drawn from those visible from `direction` (Heitz 2018). `weight` is the
// reflectance times what masking leaves. Zero weight where the direction ends below the surface.
vec3 reflect_rough(Surface s, vec3 direction, vec2 random, out vec3 weight) {
    Material material = materials[s.material];
    vec3 n = dot(direction, s.geometric) < 0.0 ? s.shading : -s.shading;
    vec3 u, v;
    basis(n, u, v);
    vec3 view = -vec3(dot(direction, u), dot(direction, v), dot(direction, n));
    view.z = max(view.z, 1e-4);
    vec3 stretched = normalize(vec3(material.alpha * view.xy, view.z));
    float length2 = dot(stretched.xy, stretched.xy);
    vec3 t1 = length2 > 0.0 ? vec3(-stretched.y, stretched.x, 0.0) * inversesqrt(length2) : vec3(1.0, 0.0, 0.0);
    vec3 t2 = cross(stretched, t1);
    float radius = sqrt(random.x);
    float angle = 2.0 * PI * random.y;
    float x = radius * cos(angle);
    float blend = 0.5 * (1.0 + stretched.z);
    float y = mix(sqrt(max(0.0, 1.0 - x * x)), radius * sin(angle), blend);
    vec3 half_way = x * t1 + y * t2 + sqrt(max(0.0, 1.0 - x * x - y * y)) * stretched;
    half_way = normalize(vec3(material.alpha * half_way.xy, max(1e-6, half_way.z)));
    vec3 local = 2.0 * dot(view, half_way) * half_way - view;
    if (local.z <= 0.0) {
        weight = vec3(0.0);
        return n;
    }
    float masking_in = smith(view.z, material.alpha);
    float masking_out = smith(local.z, material.alpha);
    // Height-correlated shadowing over the masking that the sampling already accounts for.
    weight = material.color * masking_out / (masking_in + masking_out - masking_in * masking_out);
    return normalize(u * local.x + v * local.y + n * local.z);
}

// Reflected radiance over irradiance on the perpendicular plane: the GGX lobe times the incident cosine.
vec3 rough_lobe_cosine(Surface s, vec3 direction, vec3 to_light) {
    Material material = materials[s.material];
    vec3 n = dot(direction, s.geometric) < 0.0 ? s.shading : -s.shading;
    float cos_view = max(-dot(direction, n), 1e-4);
    float cos_light = dot(to_light, n);
    if (cos_light <= 0.0) return vec3(0.0);
    vec3 half_way = normalize(to_light - direction);
    float c = clamp(dot(half_way, n), 0.0, 1.0);
    float a2 = material.alpha * material.alpha;
    // sin^2 + (alpha cos)^2, the sine by a cross product: 1 - cos^2 cancels where the lobe is narrow.
    vec3 across = cross(n, half_way);
    float d = dot(across, across) + a2 * c * c;
    float density = a2 / (PI * d * d);
    float g_view = smith(cos_view, material.alpha);
    float g_light = smith(cos_light, material.alpha);
    float masking = g_view * g_light / (g_view + g_light - g_view * g_light);
    return material.color * density * masking / (4.0 * cos_view);
}

// What a light sends to a point: unit direction to it, distance (huge for directional lights), and irradiance on the
// plane perpendicular to that direction, W/m2, without media.
struct LightSample {
    vec3 to_light;
    float distance;
    vec3 irradiance;
};

const float FAR_AWAY = 1e30;

// Full inside the inner cone, none outside the outer, smooth in the cosine between.
float spot_falloff(Light light, vec3 direction) {
    float c = dot(direction, light.direction);
    if (light.cos_inner <= light.cos_outer) return c >= light.cos_outer ? 1.0 : 0.0;
    float x = clamp((c - light.cos_outer) / (light.cos_inner - light.cos_outer), 0.0, 1.0);
    return x * x * (3.0 - 2.0 * x);
}

// What a spot light's image lets through; 1 where there is none.
vec3 spot_image(Light light, vec3 direction) {
    if (light.image == NO_TEXTURE) return vec3(1.0);
    float ahead = dot(direction, light.direction);
    if (ahead <= 0.0) return vec3(0.0);
    vec2 across = vec2(dot(direction, cross(light.direction, light.up)), -dot(direction, light.up));
    vec2 at = 0.5 + 0.5 * across / (ahead * light.half_width);
    return image_color(light.image, clamp(at, 0.0, 1.0));
}

// W/sr that leave a point or spot light along the unit direction; W/m2 of a directional light.
vec3 light_power_along(Light light, vec3 direction) {
    if (light.kind != LIGHT_SPOT) return light.intensity;
    return light.intensity * spot_falloff(light, direction) * spot_image(light, direction);
}

LightSample light_at(Light light, vec3 position) {
    LightSample result;
    if (light.kind == LIGHT_DIRECTIONAL) {
        result.to_light = -light.direction;
        result.distance = FAR_AWAY;
        result.irradiance = light.intensity;
        return result;
    }
    vec3 way = light.position - position;
    float distance2 = max(dot(way, way), 1e-20);
    result.distance = sqrt(distance2);
    result.to_light = way / result.distance;
    result.irradiance = light_power_along(light, -result.to_light) / distance2;
    return result;
}
