// Follows the camera's path through specular surfaces to a diffuse point, one invocation a pixel and layer. The first
// interface is split into its two branches, a layer each; later ones choose by chance, so that deep paths stay unbiased
// without a tree.
#include "shared/index.glsl"
#include "shared/media.glsl"
#include "shared/meets.glsl"
#include "shared/optics.glsl"
#include "shared/parts.glsl"
#include "shared/random.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "shared/film.glsl"
#include "shared/round.glsl"
#include "shared/segments.glsl"
#include "trace/interface.glsl"

layout(set = 2, binding = 1, std430) readonly buffer PrimaryIds { uvec2 primary_ids[]; };
layout(set = 2, binding = 2, std430) writeonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) writeonly buffer VisibleShades { VisibleShade visible_shades[]; };
layout(push_constant) uniform SamplePush { Sample frame; };

// Paths through more specular surfaces are given up and counted.
const uint MAX_EVENTS = 16u;

// Radiance that lights send over a rough mirror straight into the path.
vec3 highlights(Surface s, vec3 direction, uint medium) {
    vec3 sum = vec3(0.0);
    for (uint index = 0u; index < view.lights; index++) {
        LightSample light = light_at(lights[index], s.position);
        if (lights[index].medium != medium || dot(light.to_light, s.geometric) * dot(direction, s.geometric) >= 0.0) {
            continue;
        }
        vec3 lobe = rough_lobe_cosine(s, direction, light.to_light);
        if (mean(lobe) <= 0.0) continue;
        vec3 origin = leave(s, light.to_light);
        if (!trace_occluded(Ray(origin, 0.0, light.to_light, light.distance), MASK_ALL)) {
            sum += lobe * light.irradiance * transmittance(medium, origin, light.to_light, light.distance);
        }
    }
    return sum;
}

void main() {
    uint slot = linear_index();
    uint pixels = view.width * view.rows;
    if (slot >= pixels * VISIBLE_LAYERS) return;
    uint place = slot % pixels;
    RoundSample at = RoundSample(place, frame.index, frame.jitter);
    if (frame.listed != 0u) at = round_samples[place];
    uint pixel = at.pixel;
    bool reflected_layer = slot >= pixels;
    uint seed = combine(combine(view.seed, pixel + view.first_row * view.width), reflected_layer ? 1u : 0u);

    vec3 origin = view.position;
    vec3 direction = normalize(pixel_direction(uvec2(pixel % view.width, pixel / view.width), at.jitter));
    uvec2 ids = primary_ids[place];
    uint instance = ids.x - 1u; // wraps to NO_INSTANCE where nothing is seen
    uint primitive = ids.y;
    vec2 barycentrics = vec2(0.0);
    bool known = instance == NO_INSTANCE || meets(instance, primitive, origin, direction, barycentrics);

    uint medium = view.medium;
    vec3 throughput = vec3(1.0);
    vec3 collected = vec3(0.0); // radiance met on the way
    float distance = 0.0;
    bool split = false; // whether the path went through the interface that has two layers
    uint events = 0u;
    uint stretches = 0u;
    VisiblePoint point = VisiblePoint(vec3(0.0), NO_INSTANCE, 0u, 0u, 0.0, 0u);
    VisibleShade shade = VisibleShade(vec3(0.0), 0.0, vec3(0.0), 0u);

    for (; events <= MAX_EVENTS; events++) {
        if (!known) {
            Hit hit = trace_closest(Ray(origin, 0.0, direction, 1e30), MASK_ALL);
            instance = hit.instance;
            primitive = hit.primitive;
            barycentrics = hit.barycentrics;
        }
        known = false;
        Surface s;
        float segment = view.reach;
        if (instance != NO_INSTANCE) {
            s = surface_at(instance, primitive, barycentrics);
            segment = length(s.position - origin);
        }
        if (view.segments > 0u && scatters(medium) && mean(throughput) > 0.0 && all_finite(throughput)) {
            if (stretches < view.segments) {
                vec3 end = instance == NO_INSTANCE ? origin + segment * direction : s.position;
                view_segments[stretches * pixels * VISIBLE_LAYERS + slot] =
                    view_segment(origin, end, throughput, medium);
            }
            stretches++;
        }
        throughput *= transmittance(medium, origin, direction, segment);
        if (instance == NO_INSTANCE) {
            collected += throughput * view.background;
            break;
        }
        distance += segment;
        uint kind = materials[s.material].kind;
        if (kind == MATERIAL_DIFFUSE) {
            bool front = dot(direction, s.geometric) < 0.0;
            point.position = leave(s, -direction);
            point.instance = instance;
            point.normal = pack_direction(front ? s.shading : -s.shading);
            point.geometric = pack_direction(front ? s.geometric : -s.geometric);
            point.footprint = distance * view.pixel_angle;
            point.medium = medium;
            shade = VisibleShade(throughput, distance, albedo_at(s), events);
            break;
        }
        vec3 before = direction;
        bool crosses = false;
        if (kind == MATERIAL_DIELECTRIC) {
            Interface i = interface_at(s, direction);
            bool reflects;
            if (i.reflectance >= 1.0) {
                reflects = true;
            } else if (!split) {
                split = true;
                reflects = reflected_layer;
                // What was met before is in the other layer already.
                if (reflected_layer) {
                    collected = vec3(0.0);
                    stretches = 0u;
                }
                throughput *= reflects ? i.reflectance : 1.0 - i.reflectance;
            } else {
                reflects = sample_1d(at.index, combine(seed, events)) < i.reflectance;
            }
            if (reflects) {
                direction = reflected(i, direction);
            } else {
                direction = refracted(i, direction);
                // L/n^2 is what is conserved.
                throughput *= i.eta * i.eta;
                medium = i.beyond;
                crosses = true;
            }
        } else if (kind == MATERIAL_MIRROR) {
            vec3 n = dot(direction, s.geometric) < 0.0 ? s.shading : -s.shading;
            direction = normalize(reflect(direction, n));
            throughput *= materials[s.material].color;
        } else if (HAS_ROUGH) {
            collected += throughput * highlights(s, direction, medium);
            vec3 weight;
            direction = reflect_rough(s, direction, sample_2d(at.index, combine(seed, events)), weight);
            throughput *= weight;
            if (mean(weight) <= 0.0) break;
        }
        if (!stays_on_side(s, before, direction, crosses)) {
            atomicAdd(counters.wrong_side, 1u);
            break;
        }
        origin = leave(s, direction);
        if (events == MAX_EVENTS) {
            atomicAdd(counters.too_long, 1u);
            break;
        }
    }

    // A path without an interface has nothing to reflect: its second layer is empty.
    if (reflected_layer && !split) {
        collected = vec3(0.0);
        point.instance = NO_INSTANCE;
        stretches = 0u;
    }
    if (stretches > view.segments) atomicAdd(counters.stretches, 1u);
    for (uint k = stretches; k < view.segments; k++) {
        view_segments[k * pixels * VISIBLE_LAYERS + slot] = empty_segment();
    }
    if (!all_finite(collected) || !all_finite(shade.throughput) || !all_finite(point.position)) {
        atomicAdd(counters.non_finite, 1u);
        collected = vec3(0.0);
        point.instance = NO_INSTANCE;
    }
    film_direct[slot] += vec4(collected, 0.0);
    visible_points[slot] = point;
    visible_shades[slot] = shade;
}
