// The camera, and the band of the picture that is being rendered. renderer/view.rs fills it.

struct View {
    vec3 position;
    uint width;      // pixels
    vec3 right;      // half the picture's width at distance 1
    uint height;     // pixels, of the whole picture
    vec3 up;         // half the picture's height at distance 1
    uint first_row;  // of this band
    vec3 forward;    // unit
    uint rows;       // in this band
    uint medium;     // that the camera is in
    uint seed;
    float pixel_angle; // radians a pixel subtends in the picture's middle
    uint lights;
    vec3 background; // W/(m2 sr)
    float reach;     // m that rays which meet nothing are followed through a medium
    uint segments;   // stretches in media that scatter that are kept of each path; 0 where nothing scatters
    uint volume_samples; // points on each stretch that light is found at
    uint padding0;
    uint padding1;
};

layout(set = 2, binding = 0, std430) readonly buffer Views { View view; };

// What changes from sample to sample.
struct Sample {
    vec2 jitter; // position in the pixel, [0, 1)^2, the same for all pixels so that raster and rays agree
    uint index;
    uint listed; // 1: the round's list says what is sampled, and the two above do not count
};

// Not normalised: its component along `forward` is 1.
vec3 pixel_direction(uvec2 pixel, vec2 jitter) {
    vec2 at = (vec2(pixel.x, pixel.y + view.first_row) + jitter) / vec2(view.width, view.height);
    return view.forward + (2.0 * at.x - 1.0) * view.right + (1.0 - 2.0 * at.y) * view.up;
}
