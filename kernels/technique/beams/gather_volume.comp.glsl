// Media of the same density everywhere.
#include "technique/beams/gather_volume.glsl"
