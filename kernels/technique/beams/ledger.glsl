// Where the light went, and what was left out.

layout(set = 3, binding = 7, std430) buffer GenerationTallies { uint tallies[]; };

// How often something happened.
const uint TALLY_TOTAL_REFLECTION = 0u; // rays that could not be refracted
const uint TALLY_CUT = 1u;              // branches too weak to follow
const uint TALLY_WRONG_SIDE = 2u;       // rays that shading normals bent through their surface
const uint TALLY_NON_FINITE = 3u;
const uint TALLY_SILHOUETTE = 4u;       // beams that lack an edge
const uint TALLY_WIDE = 5u;             // beams whose edges part by more than can be drawn
const uint TALLY_REFINEMENTS = 6u;      // halvings of all that asked for it, for which there was no room
const uint TALLY_COUNT = 8u;

// Entries of the ledger, two words each, behind the tallies.
const uint LEDGER_MISSED = 0u;     // met no specular surface first
const uint LEDGER_LANDED = 1u;     // on diffuse surfaces
const uint LEDGER_ABSORBED = 2u;
const uint LEDGER_SCATTERED = 3u;
const uint LEDGER_ESCAPED = 4u;    // met nothing any more
const uint LEDGER_CUT = 5u;        // too weak, too wide, or more bounces than are followed
const uint LEDGER_SILHOUETTE = 6u; // of beams that lack an edge
const uint LEDGER_EMITTED = 7u;    // into the coarse cells

void book(uint entry, vec3 flux, float unit) {
    uint amount = uint(clamp(mean(flux) / unit + 0.5, 0.0, 4.0e9));
    uint at = TALLY_COUNT + 2u * entry;
    uint before = atomicAdd(tallies[at], amount);
    if (before + amount < before) atomicAdd(tallies[at + 1u], 1u);
}
