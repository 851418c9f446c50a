// Media some of which have a density grid.
#define DENSITY_GRIDS
#include "technique/beams/light_volume.glsl"
