// What of one photon goes where in the ledger, booked together in the end: an atomic is a loop over lanes to lavapipe's
// compiler, and thirty of them took it seconds.
#include "technique/photons/ledger.glsl"
#include "shared/media.glsl"

const uint FATES = 6u;
uint fates[FATES] = uint[FATES](LEDGER_EMITTED, LEDGER_ABSORBED, LEDGER_SCATTERED, LEDGER_FAINT, LEDGER_STRENGTHENED,
                                LEDGER_MISSED); // the last is where it ends
float fate_watts[FATES] = float[FATES](0.0, 0.0, 0.0, 0.0, 0.0, 0.0);

void ends(uint entry, vec3 flux) {
    fates[5] = entry;
    fate_watts[5] = mean(flux);
}

// Extinction took all of `taken`.
void takes(uint medium, vec3 taken) {
    vec3 scattered = taken * scattered_part(medium);
    fate_watts[1] += mean(taken - scattered);
    fate_watts[2] += mean(scattered);
}

// `count` is FATES, for the device to read: unrolled, this would be what it avoids.
void book_fates(uint count, float unit) {
    for (uint i = 0u; i < count; i++) {
        if (fate_watts[i] > 0.0) book(fates[i], vec3(fate_watts[i]), unit);
    }
}
