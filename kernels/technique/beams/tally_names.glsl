// How often what, in two words each; renderer/technique/beams/accumulate/counters.rs names them in this order.
const uint TALLY_TESTS = 0u;      // of a visible point or a view segment against a beam
const uint TALLY_FRAGMENTS = 1u;  // that were inside
const uint TALLY_RAYS = 2u;       // for shadows
const uint TALLY_SHADOWED = 3u;   // that found something in the way
const uint TALLY_NON_FINITE = 4u; // beams and contributions that were left out
const uint TALLY_DRAWN = 5u;      // fragments of rasterised hulls
const uint TALLIES = 6u;
