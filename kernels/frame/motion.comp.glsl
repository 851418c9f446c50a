// How far what is seen at each pixel's centre has moved in the picture since the frame before, one invocation a pixel.
#include "shared/index.glsl"
#include "shared/motion.glsl"

layout(set = 3, binding = 3, std430) writeonly buffer MotionVectors { vec2 motion_vectors[]; };

void main() {
    uint pixel = linear_index();
    if (pixel >= view.width * view.rows) return;
    Motion m = motion_of(pixel);
    motion_vectors[pixel] = m.was_before ? m.moved : vec2(0.0);
}
