// Which sample of which pixel each slot of an adaptive round stands for: slot = layer * pixels + place, as ever, but a
// place is no longer a pixel. renderer/adaptive.rs.

struct RoundSample {
    uint pixel;
    uint index;  // of the pixel's own sequence
    vec2 jitter; // position in the pixel, [0, 1)^2, different from pixel to pixel; frame/primary fills it
};

layout(set = 2, binding = 4, std430) buffer RoundSamples { RoundSample round_samples[]; };

// The pixel's samples after the pilot stand in line behind those of the pixels before it, and rounds take as many from
// the line as the picture has pixels: from place `first_place` of round `first_round` to just before `last_place` of
// round `last_round`.
struct PixelPlan {
    uint first_round; // counted from the end of the pilot
    uint first_place;
    uint last_round;
    uint last_place;
};

struct RoundPush {
    uint pilot;    // samples a pixel of the pilot
    uint index;    // of the round, the pilot's included
    uint padding0;
    uint padding1;
};

// The places of one pixel in a round.
struct Places {
    uint from;
    uint to;    // one past the last
    uint taken; // samples of the pixel before this round
};

Places places_of(uint pixel, PixelPlan plan, RoundPush push, uint pixels) {
    if (push.index < push.pilot) return Places(pixel, pixel + 1u, push.index);
    uint number = push.index - push.pilot;
    if (number < plan.first_round || number > plan.last_round) return Places(0u, 0u, 0u);
    bool first = number == plan.first_round;
    uint from = first ? plan.first_place : 0u;
    uint to = number == plan.last_round ? plan.last_place : pixels;
    uint before = first ? 0u : (number - plan.first_round) * pixels - plan.first_place;
    return Places(from, to, push.pilot + before);
}
