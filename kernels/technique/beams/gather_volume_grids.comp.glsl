// Media some of which have a density grid.
#define DENSITY_GRIDS
#include "technique/beams/gather_volume.glsl"
