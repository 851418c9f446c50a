// Media some of which have a density grid.
#include "technique/beams/follow.glsl"
