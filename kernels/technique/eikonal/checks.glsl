// How well a wave has settled, and what is still to be done about it.
struct EikonalChecks {
    uint worst;     // bits of the largest difference from what neighbours say, in cells times index
    uint unsettled; // cells that differ by more than was tolerated
    uint unreached; // cells without a value
    uint reach_u;   // columns from the foot to the farthest of these, and one more
    uint reach_v;
    uint lower_u;   // columns that further sweeps visit
    uint lower_v;
    uint size_u;
    uint size_v;
    uint groups[3]; // of such a sweep; none where all has settled
};

layout(set = 3, binding = 2, std430) buffer EikonalCheckSums { EikonalChecks checks; };
