// What a scene may have, known when its pipelines are made: code for what it has not is left out. Kernels are correct
// where both are true. renderer/gpu/variant.rs sets them.
layout(constant_id = 0) const bool HAS_GRIDS = true; // media with density grids
layout(constant_id = 1) const bool HAS_ROUGH = true; // rough mirrors
