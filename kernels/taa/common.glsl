// What temporal anti-aliasing keeps of each frame. All of the whole picture, pixel by pixel.

struct TaaLight {
    vec3 radiance; // W/(m2 sr), the frame's own mean
    uint instance; // that the pixel's centre shows first; NO_INSTANCE: the background
};

struct TaaSeen {
    vec2 motion;    // pixels, from the place in the frame before
    float distance; // m from the camera; 1 for the background
    float then;     // the same in the frame before; negative where it was not before that camera
};

// Where what a pixel shows was in the frame that comes next, counted backwards.
struct TaaPlace {
    vec2 at;        // pixels from the upper left corner
    float distance; // m
    uint instance;  // LOST: it cannot be followed any further
};

const uint LOST = 0xfffffffeu;

// How luma went over the frames of the past, along a pixel's way back.
struct TaaRun {
    float last;   // of the frame before
    float recent; // sum over the newer half of the frames
    float older;  // and over the others
    float steps;  // squared differences between neighbours, sum
};

struct TaaPush {
    uint width;
    uint height;
    float weight; // of the frame at hand; frames of the past have 1 each, or less where light changes
    uint back;    // which frame of the past, counted backwards from 1
    uint half_way; // frames in the newer half, the one at hand among them
    uint padding0;
    uint padding1;
    uint padding2;
};

vec3 to_luma(vec3 c) { // YCoCg
    return vec3(0.25 * c.r + 0.5 * c.g + 0.25 * c.b, 0.5 * (c.r - c.b), 0.5 * c.g - 0.25 * (c.r + c.b));
}

vec3 from_luma(vec3 c) {
    return vec3(c.x + c.y - c.z, c.x + c.z, c.x - c.y - c.z);
}

// Where what a pixel of the frame at hand shows was in the frame before.
TaaPlace first_place(uint pixel, uint width, TaaLight light, TaaSeen seen) {
    vec2 centre = vec2(pixel % width, pixel / width) + 0.5;
    return TaaPlace(centre - seen.motion, seen.then, seen.then < 0.0 ? LOST : light.instance);
}
