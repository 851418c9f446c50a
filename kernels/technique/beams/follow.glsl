// Follows the rays of new vertices from the light through all sheets. One trace call in one loop: neighbours at different
// sheets do not wait for each other, and lavapipe compiles one traversal.
#include "technique/beams/vertex.glsl"
#include "shared/optics.glsl"
#include "shared/media.glsl"
#include "technique/beams/ledger.glsl"
#include "trace/interface.glsl"

layout(push_constant) uniform JitterPush {
    vec2 jitter; // of the lattice, in coarse cells
    uint padding0;
    uint padding1;
} push;

layout(set = 3, binding = 21, std430) readonly buffer LightTexels { LightTexel light_texels[]; };

// Widths of a finest cell by which what is opaque may stand before the specular surface for the ray to go on, hidden: where a
// wall meets the water, beams need an edge behind the wall. They have all of their light, and points that it does not get to
// lie behind the wall for shadows' rays.
const float HIDDEN_CELLS = 4.0;

float hidden_within(LightView v, float distance) {
    vec2 cell = coarse_cell(v) / float(1u << settings.levels);
    return HIDDEN_CELLS * max(cell.x, cell.y) * (v.perspective != 0u ? distance : 1.0);
}

// What the light's own ray meets, as the view's texel at that vertex has it.
bool look_up(LightView v, LatticePlace place, inout BeamVertex ray) {
    uvec2 at = uvec2(place.column, place.row);
    LightTexel specular = light_texels[light_texel_index(v, LIGHT_SPECULAR, at)];
    LightTexel opaque = light_texels[light_texel_index(v, LIGHT_OPAQUE, at)];
    bool lit = lit_specular(specular, opaque);
    if (specular.instance == NO_INSTANCE) return false;
    if (!lit && specular.depth - opaque.depth > hidden_within(v, opaque.depth)) return false;
    ray.target = specular.instance;
    ray.primitive = specular.primitive;
    ray.barycentrics = packUnorm2x16(specular.barycentrics);
    ray.distance = specular.depth;
    return !lit;
}

// What happens to a ray at the surface it has met: its own next ray, as far as it is known before it is traced. False where
// nothing goes on in that sheet.
bool branch(BeamVertex before, vec3 arriving, bool refracts, out BeamVertex next, out vec3 origin) {
    next = before;
    origin = vec3(0.0);
    Surface s = surface_at(before.target, before.primitive, unpackUnorm2x16(before.barycentrics));
    // Barycentrics are packed and the landing is as far off as its ray is long; both agree on the plane.
    vec3 place = landing(before);
    s.position = place - s.geometric * dot(place - s.position, s.geometric);
    Material material = materials[s.material];
    bool crosses = false;
    if (material.kind == MATERIAL_DIELECTRIC) {
        Interface i = interface_at(s, before.direction);
        if (refracts) {
            if (i.reflectance >= 1.0) {
                atomicAdd(tallies[TALLY_TOTAL_REFLECTION], 1u);
                return false;
            }
            next.throughput = arriving * (1.0 - i.reflectance);
            next.direction = refracted(i, before.direction);
            next.medium = i.beyond;
            crosses = true;
        } else {
            next.throughput = arriving * i.reflectance;
            next.direction = reflected(i, before.direction);
        }
    } else {
        // Rough mirrors spread light, which three rays cannot say.
        if (refracts || material.kind != MATERIAL_MIRROR) return false;
        vec3 n = dot(before.direction, s.geometric) < 0.0 ? s.shading : -s.shading;
        next.throughput = arriving * material.color;
        next.direction = normalize(reflect(before.direction, n));
    }
    if (mean(next.throughput) < settings.cutoff) {
        atomicAdd(tallies[TALLY_CUT], 1u);
        return false;
    }
    if (!stays_on_side(s, before.direction, next.direction, crosses)) {
        atomicAdd(tallies[TALLY_WRONG_SIDE], 1u);
        return false;
    }
    next.position = s.position;
    next.normal = pack_direction(s.shading);
    next.source = before.target;
    origin = leave(s, next.direction);
    if (!all_finite(next.direction) || !all_finite(next.throughput)) {
        atomicAdd(tallies[TALLY_NON_FINITE], 1u);
        return false;
    }
    return true;
}

void main() {
    uint number = state.traced + linear_index();
    if (number >= state.waiting) return;
    LatticePlace place = lattice_places[number];
    LightView v = light_views[place.view];
    Light light = lights[v.light];

    BeamVertex first = BeamVertex(vec3(0.0), 0u, vec3(0.0, 1.0, 0.0), 0.0, vec3(1.0), light.medium, NO_INSTANCE,
                                  NO_INSTANCE, 0u, 0u);
    vec2 chart = lattice_chart(v, vec2(place.column, place.row), push.jitter);
    light_ray(v, chart, first.position, first.direction);
    if (v.perspective == 0u) {
        // It has come through all of the medium that lies before the plane on which the view starts.
        first.throughput = transmittance(first.medium, first.position, -first.direction, FAR_AWAY);
    }

    // The first two turns are the light's own ray: to what it meets, and to what is specular close behind that.
    for (uint turn = 0u; turn <= settings.sheets + 1u; turn++) {
        uint sheet = turn - 2u;
        BeamVertex next = first;
        vec3 origin = first.position;
        float farthest = 1e30;
        uint mask = MASK_ALL;
        if (turn == 1u) {
            if (settings.buffered != 0u || first.target == NO_INSTANCE || goes_on(first.target)) continue;
            farthest = first.distance + hidden_within(v, first.distance);
            mask = MASK_SPECULAR;
        }
        if (turn > 1u) {
            sheet_records[number * settings.sheets + sheet] = NO_RECORD;
            uint parent = sheet < 2u ? NO_RECORD : record_of(number, (sheet - 2u) / 2u);
            if (sheet >= 2u && parent == NO_RECORD) continue;
            BeamVertex before = first;
            if (sheet >= 2u) before = beam_vertices[parent];
            if (!goes_on(before.target)) continue;
            vec3 arriving = before.throughput *
                            transmittance(before.medium, before.position, before.direction, before.distance);
            if (!branch(before, arriving, (sheet & 1u) == 0u, next, origin)) continue;
        }
        if (turn == 0u && settings.buffered != 0u) {
            if (look_up(v, place, first)) lattice_places[number].hidden = 1u;
            continue;
        }
        Hit hit = trace_closest(Ray(origin, 0.0, next.direction, farthest), mask);
        if (turn == 1u && hit.instance == NO_INSTANCE) continue;
        next.target = hit.instance;
        next.primitive = hit.primitive;
        next.barycentrics = packUnorm2x16(hit.barycentrics);
        next.distance = hit.instance == NO_INSTANCE ? settings.reach : hit.t;
        if (turn <= 1u) {
            first = next;
            if (turn == 1u) lattice_places[number].hidden = 1u;
            continue;
        }
        uint record = atomicAdd(state.records, 1u);
        if (record >= settings.records) continue;
        atomicAdd(sheet_counts[sheet], 1u);
        beam_vertices[record] = next;
        sheet_records[number * settings.sheets + sheet] = record;
    }
}
