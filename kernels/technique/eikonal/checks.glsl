// How well a wave has settled, and how much is still to be done about it.
struct EikonalChecks {
    uint worst;     // bits of the largest difference from what neighbours say, in cells times index
    uint unsettled; // cells that differ by more than was tolerated
    uint unreached; // cells without a value
    uint groups_x;  // of a turn of a further sweep; none where all has settled
    uint groups_y;
    uint groups_z;
    uint asked;     // blocks that are to be visited again
    uint padding0;
};

layout(set = 3, binding = 2, std430) buffer EikonalCheckSums { EikonalChecks checks; };
