// Media some of which have a density grid.
#include "technique/beams/gather_volume.glsl"
