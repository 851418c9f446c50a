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

// What of a corner's light arrives at its branches after sheet `parent`, 0 and 1 being those of the light's own ray.
vec3 passed_on(vec3 power, uint vertex, uint first_child) {
    vec3 sum = vec3(0.0);
    for (uint sheet = first_child; sheet < min(first_child + 2u, settings.sheets); sheet++) {
        uint record = record_of(vertex, sheet);
        if (record != NO_RECORD) sum += power * beam_vertices[record].throughput;
    }
    return sum;
}

void book_loss(vec3 lost, uint surface) {
    bool mirror = materials[instances[surface].material].kind == MATERIAL_MIRROR;
    note(mirror ? LEDGER_ABSORBED : LEDGER_CUT, lost);
}

// From the light to the first surface.
void book_start(BeamLeaf leaf, vec3 power) {
    for (int i = 0; i < 3; i++) {
        uint vertex = leaf.vertices[i];
        uint record = record_of(vertex, 0u);
        if (record == NO_RECORD) record = record_of(vertex, 1u);
        LatticePlace place = lattice_places[vertex];
        if (record == NO_RECORD || place.hidden != 0u) {
            note(LEDGER_MISSED, power);
            continue;
        }
        LightView v = light_views[place.view];
        BeamVertex ray = beam_vertices[record];
        vec3 way = v.perspective != 0u ? ray.position - v.origin : v.forward * dot(ray.position - v.origin, v.forward);
        float distance = length(way);
        vec3 from = ray.position - way;
        uint medium = lights[v.light].medium;
        vec3 left = v.perspective != 0u ? power : travel(power, medium, from, -v.forward, FAR_AWAY);
        left = travel(left, medium, from, way / max(distance, 1e-20), distance);
        book_loss(left - passed_on(power, vertex, 0u), ray.source);
    }
}

void main() {
    uint index = linear_index();
    if (index >= state.leaves) return;
    BeamLeaf leaf = beam_leaves[index];
    if (!is_lit(leaf)) return;
    vec3 power = leaf_flux(leaf) / 3.0;
    book_start(leaf, power);
    for (uint sheet = 0u; sheet < settings.sheets; sheet++) {
        if (sheet_counts[sheet] == 0u) continue;
        BeamEdges e = edges_of(leaf, sheet);
        if (!e.drawn && any(notEqual(e.records, uvec3(NO_RECORD)))) {
            atomicAdd(tallies[e.complete ? TALLY_WIDE : TALLY_SILHOUETTE], 1u);
        }
        for (int i = 0; i < 3; i++) {
            if (e.records[i] == NO_RECORD || lattice_places[leaf.vertices[i]].hidden != 0u) continue;
            BeamVertex ray = beam_vertices[e.records[i]];
            float gain = ray_areas[e.records[i]].gain;
            vec3 onward = vec3(0.0);
            if (goes_on(ray.target)) onward = passed_on(power, leaf.vertices[i], 2u * sheet + 2u);
            // No beam round this ray is drawn on this stretch; those that follow may be.
            if (gain <= 0.0) note(e.complete ? LEDGER_CUT : LEDGER_SILHOUETTE, power * ray.throughput - onward);
            // Otherwise, those that are carry the light of those that are not.
            if (!e.drawn) continue;
            vec3 left = travel(gain * power * ray.throughput, ray.medium, ray.position, ray.direction, ray.distance);
            if (goes_on(ray.target)) {
                book_loss(left - gain * onward, ray.target);
            } else {
                note(ray.target == NO_INSTANCE ? LEDGER_ESCAPED : LEDGER_LANDED, left);
            }
        }
    }
}
