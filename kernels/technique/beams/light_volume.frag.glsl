// Media of the same density everywhere.
#define EVEN_MEDIA
#include "technique/beams/light_volume.glsl"
