// Media of the same density everywhere.
#define EVEN_MEDIA
#include "technique/beams/light.glsl"
