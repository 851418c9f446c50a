// Workgroups of indirect dispatches, three numbers, and their product's least.
layout(set = 3, binding = 19, std430) buffer BeamSizes { uvec4 sizes[]; };
// Sums of all blocks: of leaves, of beams.
layout(set = 3, binding = 13, std430) buffer ScanTotals { uint scan_totals[]; };

const uint SIZE_LEAVES = 0u; // blocks of leaves
const uint SIZE_SHEETS = 1u; // those of every sheet
const uint SIZE_RAYS = 2u;   // vertices times sheets
