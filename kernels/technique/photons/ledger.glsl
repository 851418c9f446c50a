// Where the light went; renderer/technique/photons/ledger.rs has the names in this order. Two words an entry.
layout(set = 3, binding = 9, std430) buffer Ledger { uint ledger[]; };

const uint LEDGER_EMITTED = 0u;
const uint LEDGER_MISSED = 1u;     // met nothing specular first
const uint LEDGER_ROUGH = 2u;      // met a mirror rougher than those that are followed
const uint LEDGER_ABSORBED = 3u;
const uint LEDGER_SCATTERED = 4u;
const uint LEDGER_LANDED = 5u;     // found in the image spaces, where the camera's shows it
const uint LEDGER_RESCUED = 6u;    // found by a ray
const uint LEDGER_HIDDEN = 7u;     // found in a light's view, on what the camera's does not show
const uint LEDGER_LOST = 8u;       // by both image spaces
const uint LEDGER_ESCAPED = 9u;    // rays of rescued photons that met nothing
const uint LEDGER_SPECULAR = 10u;  // rays of rescued photons that met another specular surface
const uint LEDGER_WRONG_SIDE = 11u; // bent across the surface by shading normals
const uint LEDGER_NON_FINITE = 12u;
const uint LEDGER_FAINT = 13u;      // not followed, by chance
const uint LEDGER_STRENGTHENED = 14u; // what those that were followed instead have more

void book(uint entry, vec3 flux, float unit) {
    uint amount = uint(clamp(mean(flux) / unit + 0.5, 0.0, 4.0e9));
    uint before = atomicAdd(ledger[2u * entry], amount);
    if (before + amount < before) atomicAdd(ledger[2u * entry + 1u], 1u);
}
