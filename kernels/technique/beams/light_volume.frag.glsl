// Media of the same density everywhere.
#include "technique/beams/light_volume.glsl"
