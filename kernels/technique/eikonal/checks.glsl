// How well a wave has settled, and what is still to be done about it.
struct EikonalChecks {
    uint worst;     // bits of the largest difference from what neighbours say, in cells times index
    uint unsettled; // cells that differ by more than was tolerated
    uint unreached; // cells without a value
    uint padding0;
    uint groups[4]; // of a further sweep: three counts, none where all has settled
};

layout(set = 3, binding = 2, std430) buffer EikonalCheckSums { EikonalChecks checks; };
