// Decides which edges of the mesh so far are split (Liktor and Dachsbacher 2011, section 4.2): a candidate vertex is made
// where either triangle on its edge asks for it. Triangles are judged by their corners' rays alone.
#include "technique/beams/vertex.glsl"
#include "technique/beams/stages.glsl"
#include "technique/beams/ledger.glsl"
#include "shared/view.glsl"

// Metres from the camera to the nearest point of the beam's central ray.
float nearest_distance(BeamVertex rays[3]) {
    vec3 from = (rays[0].position + rays[1].position + rays[2].position) / 3.0;
    vec3 to = (landing(rays[0]) + landing(rays[1]) + landing(rays[2])) / 3.0;
    vec3 way = to - from;
    float along = clamp(dot(view.position - from, way) / max(dot(way, way), 1e-20), 0.0, 1.0);
    return length(from + along * way - view.position);
}

float longest_edge(vec3 a, vec3 b, vec3 c) {
    return max(length(b - a), max(length(c - b), length(a - c)));
}

// Surface discontinuity: at the start in what is left and in normals, at the end in what is met and how far away.
bool breaks(BeamVertex rays[3]) {
    if (!bound_beam(rays[0], rays[1], rays[2])) return true;
    if (rays[0].target != rays[1].target || rays[0].target != rays[2].target) return true;
    vec3 a = unpack_direction(rays[0].normal);
    vec3 b = unpack_direction(rays[1].normal);
    vec3 c = unpack_direction(rays[2].normal);
    if (min(dot(a, b), min(dot(b, c), dot(c, a))) < settings.cos_normal) return true;
    float least = min(rays[0].distance, min(rays[1].distance, rays[2].distance));
    float most = max(rays[0].distance, max(rays[1].distance, rays[2].distance));
    return most - least > settings.depth * least;
}

// Whether light converges: what is left of the cross-section at the end, negative where it has turned over.
bool focuses(BeamVertex rays[3]) {
    vec3 way = rays[0].direction + rays[1].direction + rays[2].direction;
    vec3 from = rays[0].position;
    float start = dot(way, cross(rays[1].position - from, rays[2].position - from));
    vec3 to = landing(rays[0]);
    float end = dot(way, cross(landing(rays[1]) - to, landing(rays[2]) - to));
    return end * sign(start) < settings.convergence * abs(start);
}

// Square of the length of the edge that it is the middle of, in columns.
float edge_length2(Middle m) {
    float side = 2.0 * float(m.half_side);
    return side * side * (m.of_cell ? 2.0 : 1.0);
}

// How far the middle of an edge will land beside the mean of its ends, m, as one that is there tells: deviations go with
// the square of the edge. Nothing where the vertex is of the coarse grid.
float bend(uint view_index, ivec2 at, uint sheet, float length2) {
    Middle m = middle_at(view_index, at);
    if (m.half_side == 0) return 0.0;
    ivec2 first, second;
    edge_ends(m, first, second);
    uvec3 known = uvec3(vertex_at(view_index, at), vertex_at(view_index, first), vertex_at(view_index, second));
    if (any(equal(known, uvec3(NO_VERTEX)))) return 0.0;
    uvec3 records = uvec3(record_of(known.x, sheet), record_of(known.y, sheet), record_of(known.z, sheet));
    if (any(equal(records, uvec3(NO_RECORD)))) return 0.0;
    vec3 ends = landing(beam_vertices[records.y]) + landing(beam_vertices[records.z]);
    return length(landing(beam_vertices[records.x]) - 0.5 * ends) * length2 / edge_length2(m);
}

// Of the light's power at the corners, the largest difference over the largest.
float power_contrast(LightView v, ivec2 corners[3]) {
    float least = 3.0e38;
    float most = 0.0;
    for (int i = 0; i < 3; i++) {
        float power = mean(light_power(v, lights[v.light], lattice_chart(v, vec2(corners[i]), push.jitter)));
        least = min(least, power);
        most = max(most, power);
    }
    return most > 0.0 ? (most - least) / most : 0.0;
}

// Whether no beam is drawn between them however narrow, but for what three rays can miss.
bool lights_nothing(BeamVertex rays[3]) {
    for (int i = 0; i < 3; i++) {
        vec3 scattering = media[rays[i].medium].scattering;
        if (rays[i].target != NO_INSTANCE || any(greaterThan(scattering, vec3(0.0)))) return false;
    }
    return true;
}

// Whether the triangle, whose last corner is the apex, asks for a split.
bool asks(uint view_index, ivec2 corners[3], float length2) {
    uint vertices[3];
    for (int i = 0; i < 3; i++) {
        vertices[i] = vertex_at(view_index, corners[i]);
        if (vertices[i] == NO_VERTEX) return false;
    }
    if (push.stage / 2u < settings.least_level) return true;
    bool patterned = (settings.rules & RULE_LIGHT) != 0u &&
                     power_contrast(light_views[view_index], corners) > settings.pattern;
    for (uint sheet = 0u; sheet < settings.sheets; sheet++) {
        uint records[3] = uint[3](record_of(vertices[0], sheet), record_of(vertices[1], sheet),
                                  record_of(vertices[2], sheet));
        uint missing = 0u;
        for (int i = 0; i < 3; i++) {
            missing += uint(records[i] == NO_RECORD || lattice_places[vertices[i]].hidden != 0u);
        }
        if (missing == 3u) continue;
        if (missing > 0u) {
            if ((settings.rules & RULE_SURFACE) != 0u) return true;
            continue;
        }
        BeamVertex rays[3] = BeamVertex[3](beam_vertices[records[0]], beam_vertices[records[1]], beam_vertices[records[2]]);
        if (lights_nothing(rays)) continue;
        float throughput = mean(rays[0].throughput + rays[1].throughput + rays[2].throughput) / 3.0;
        bool wanted = patterned;
        wanted = wanted || ((settings.rules & RULE_SURFACE) != 0u && breaks(rays));
        // A triangle of stage s has about 2^-s of its coarse cell's flux.
        float flux = throughput / float(1u << push.stage);
        wanted = wanted || ((settings.rules & RULE_ENERGY) != 0u && flux > settings.energy && focuses(rays));
        float pixel = view.pixel_angle * max(nearest_distance(rays), 1e-6);
        if ((settings.rules & RULE_DEVIATION) != 0u && flux > settings.energy) {
            for (int i = 0; i < 3; i++) {
                wanted = wanted || bend(view_index, corners[i], sheet, length2) > settings.deviation * pixel;
            }
        }
        if (wanted && (settings.rules & RULE_CAMERA) != 0u) {
            float start = longest_edge(rays[0].position, rays[1].position, rays[2].position);
            float end = longest_edge(landing(rays[0]), landing(rays[1]), landing(rays[2]));
            wanted = max(start, end) > settings.pixels * pixel;
        }
        if (wanted) return true;
    }
    return false;
}

// Whether there is room for all triangles to be split: coarser beams everywhere are better than none in places. There are
// twice as many triangles as vertices, about half of them with a beam that lights something.
bool has_room() {
    uint vertices = state.waiting;
    uint records = min(state.records, settings.records);
    return vertices <= settings.vertices / 2u && records <= settings.records / 2u && records <= settings.beams / 2u;
}

void main() {
    uint index = linear_index();
    if (index >= settings.views * stage_size()) return;
    if (!has_room()) {
        if (index == 0u) atomicAdd(tallies[TALLY_REFINEMENTS], 1u);
        return;
    }
    Middle m = candidate(index);
    ivec2 from, to, first, second;
    edge_ends(m, from, to);
    edge_apexes(m, first, second);
    bool wanted = false;
    for (int side = 0; side < 2; side++) {
        if (!wanted) wanted = asks(m.view, ivec2[3](from, to, side == 0 ? first : second), edge_length2(m));
    }
    if (wanted) make_vertex(m.view, m.at);
}
