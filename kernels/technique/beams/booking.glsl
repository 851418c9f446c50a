// Books where the light of each leaf goes, a third of it with each of its corners' rays.
#include "technique/beams/edges.glsl"
#include "technique/beams/ledger.glsl"
#include "technique/beams/ray_area.glsl"
#include "shared/optics.glsl"
#include "shared/media.glsl"

void note(uint entry, vec3 flux) {
    book(entry, max(flux, vec3(0.0)), settings.ledger_unit);
}

// Books what a medium took from `flux` on the way, and returns the rest.
vec3 travel(vec3 flux, uint medium, vec3 from, vec3 way, float distance) {
    vec3 left = flux * transmittance(medium, from, way, distance);
    vec3 extinction = media[medium].absorption + media[medium].scattering;
    vec3 scattered = media[medium].scattering / max(extinction, vec3(1e-30));
    note(LEDGER_SCATTERED, (flux - left) * scattered);
    note(LEDGER_ABSORBED, (flux - left) * (1.0 - scattered));
    return left;
}

// What of a corner's light arrives at its branches, two sheets from `first_child` on: 0 of the light's own ray.
vec3 passed_on(vec3 power, uint vertex, uint first_child) {
    vec3 sum = vec3(0.0);
    for (uint sheet = first_child; sheet < min(first_child + 2u, settings.sheets); sheet++) {
        uint record = record_of(vertex, sheet);
        if (record != NO_RECORD) sum += power * beam_vertices[record].throughput;
    }
    return sum;
}

// The way of the light from where it starts to the first surface, at which `ray` begins.
void first_leg(uint vertex, BeamVertex ray, out uint medium, out vec3 from, out vec3 way, out float distance) {
    LightView v = light_views[lattice_places[vertex].view];
    medium = lights[v.light].medium;
    vec3 whole = ray.position - v.origin;
    bool perspective = v.perspective != 0u;
    // The sun's light has come through all of the medium: looked at from its end.
    from = perspective ? v.origin : ray.position;
    distance = perspective ? length(whole) : FAR_AWAY;
    way = perspective ? whole / max(distance, 1e-20) : -v.forward;
}

// Each of these is called at one place: compilers make a copy of all code for every call, and of a loop's for every turn
// that they can count.
void main() {
    uint index = linear_index();
    if (index >= state.leaves) return;
    BeamLeaf leaf = beam_leaves[index];
    if (!is_lit(leaf)) return;
    vec3 power = leaf_flux(leaf) / 3.0;
    // The first turn is the way to the first surface.
    for (uint turn = 0u; turn <= settings.sheets; turn++) {
        bool start = turn == 0u;
        uint sheet = start ? 0u : turn - 1u;
        if (!start && sheet_counts[sheet] == 0u) continue;
        BeamEdges e = edges_of(leaf, sheet);
        if (!start && !e.drawn && any(notEqual(e.records, uvec3(NO_RECORD)))) {
            atomicAdd(tallies[e.complete ? TALLY_WIDE : TALLY_SILHOUETTE], 1u);
        }
        for (uint i = 0u; i < settings.corners; i++) {
            uint vertex = leaf.vertices[i];
            uint record = e.records[i];
            if (start && record == NO_RECORD) record = record_of(vertex, 1u);
            bool lit = record != NO_RECORD && lattice_places[vertex].hidden == 0u;
            if (!start && !lit) continue;
            uint entry = LEDGER_MISSED;
            vec3 flux = power;
            if (lit) {
                BeamVertex ray = beam_vertices[record];
                uint medium = ray.medium;
                vec3 from = ray.position;
                vec3 way = ray.direction;
                float distance = ray.distance;
                uint surface = ray.target;
                float gain = 1.0;
                if (start) {
                    first_leg(vertex, ray, medium, from, way, distance);
                    surface = ray.source;
                } else {
                    flux *= ray.throughput;
                    gain = ray_areas[record].gain;
                }
                vec3 onward = vec3(0.0);
                if (goes_on(surface)) onward = passed_on(power, vertex, start ? 0u : 2u * sheet + 2u);
                if (start || e.drawn) {
                    flux = travel(gain * flux, medium, from, way, distance) - gain * onward;
                    entry = surface == NO_INSTANCE ? LEDGER_ESCAPED : LEDGER_LANDED;
                    if (goes_on(surface)) {
                        bool mirror = materials[instances[surface].material].kind == MATERIAL_MIRROR;
                        entry = mirror ? LEDGER_ABSORBED : LEDGER_CUT;
                    }
                } else {
                    // Beams round this ray that are drawn carry the light of those that are not. Where none is on this
                    // stretch, those that follow may be.
                    if (gain > 0.0) continue;
                    flux -= onward;
                    entry = e.complete ? LEDGER_CUT : LEDGER_SILHOUETTE;
                }
            }
            note(entry, flux);
        }
    }
}
