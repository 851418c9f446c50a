// How much of a medium of uneven density lies along the edges of a beam, at places that all who look into it share: a beam
// is met by many pixels, and a walk through smoke takes hundreds of look-ups.
#include "technique/beams/beam.glsl"

const uint BEAM_PLACES = 16u;

// Of one edge, from where it leaves its surface.
struct BeamDepths {
    float first;                   // m along it to where its medium's density begins
    float step;                    // m from place to place
    float total;                   // m of density 1, up to the last place
    uint parts[BEAM_PLACES / 2u];  // of the total, up to each place after the first, two halves a word
};
