// Media some of which have a density grid.
#include "technique/beams/light_volume.glsl"
