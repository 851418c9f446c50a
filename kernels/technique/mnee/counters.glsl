// How often what happened, in two words each; renderer/technique/mnee/counters.rs names them in this order.
const uint COUNT_POINTS = 0u;            // visible points that a light may reach through one surface
const uint COUNT_STARTS = 1u;            // where the segment to the light meets such a surface
const uint COUNT_TRIANGLES = 2u;         // crossed by walks
const uint COUNT_ENDED_BOUNDARY = 3u;    // walks that came to an open edge,
const uint COUNT_ENDED_SLOPES = 4u;      // to where no slope of the surface refracts to the point,
const uint COUNT_ENDED_CLOSED = 5u;      // back to their start,
const uint COUNT_ENDED_CREASE = 6u;      // to an edge where normals jump
const uint COUNT_STEP_CAP = 7u;          // or to their last step
const uint COUNT_WALKS_DROPPED = 8u;     // for which there was no room
const uint COUNT_ARCS = 9u;              // handed to the solver
const uint COUNT_ARCS_DROPPED = 10u;     // for which there was no room
const uint COUNT_ROOTS = 11u;            // found, each once
const uint COUNT_UNSOLVED = 12u;         // changes of sign that are no root
const uint COUNT_WRONG_SIDE = 13u;       // roots on a face whose shading normal bends the path across it, or turned away
const uint COUNT_BEHIND = 14u;           // roots behind the visible point's own surface
const uint COUNT_BLOCKED = 15u;          // by a diffuse surface
const uint COUNT_SECOND_CROSSING = 16u;  // blocked by a specular surface
const uint COUNT_NON_FINITE = 17u;
const uint COUNT_PATHS = 18u;            // that carried light
const uint COUNT_SEEDS = 19u;            // triangles tried apart from walks
const uint COUNT_DUPLICATES = 20u;       // roots found again
const uint COUNT_TRIALS = 21u;           // starts of Newton's method
const uint COUNT_PROJECTIONS = 22u;      // its steps
const uint COUNT_NOT_CONVERGED = 23u;    // trials that came to no root
const uint COUNT_TRIALS_CAPPED = 24u;    // paths that the last trial allowed had not found again
const uint COUNT_ENDED_FOUND = 25u;      // walks for one path only, that came to it
const uint COUNT_ROOTS_DROPPED = 26u;    // for which there was no room
const uint COUNT_FOOTPRINTS_LEFT_OUT = 27u; // too large for the grid, or of no definite direction
const uint LONGEST_WALK = 2u * 28u;      // after the counters: one word, triangles

layout(set = 3, binding = 8, std430) buffer MneeCounters { uint mnee_counters[]; };

void count(uint what, uint amount) {
    if (amount == 0u) return;
    uint before = atomicAdd(mnee_counters[2u * what], amount);
    if (before + amount < before) atomicAdd(mnee_counters[2u * what + 1u], 1u);
}
