// Looks frames of the past up where a pixel's way back leads, and follows it one frame further. The way goes through all
// frames' motion, and each frame is looked up once, at the end of it: nothing is filtered again and again, as where one
// history is carried from frame to frame.
layout(set = 3, binding = 2, std430) buffer TaaPlaces { TaaPlace taa_places[]; };
layout(set = 3, binding = 4, std430) readonly buffer PastLights { TaaLight past_lights[]; };
layout(set = 3, binding = 5, std430) readonly buffer PastSeens { TaaSeen past_seens[]; };
layout(push_constant) uniform PastPush { TaaPush push; };

// Of the distance, by which the same surface may be off where it is expected: more than its slant makes between pixels.
const float SAME_DISTANCE = 0.1;
// Pixels: nearer to a pixel's centre its light is taken as it is, so that rounding does not blur it.
const float SAME_PLACE = 1e-3;
// Of the four pixels' weights, below which too little of the surface was seen.
const float LEAST_WEIGHT = 0.1;
bool inside(ivec2 at) {
    return all(greaterThanEqual(at, ivec2(0))) && at.x < int(push.width) && at.y < int(push.height);
}

uint index_of(ivec2 at) {
    return uint(at.y) * push.width + uint(at.x);
}

bool shows(uint index, TaaPlace place) {
    return past_lights[index].instance == place.instance &&
           abs(past_seens[index].distance - place.distance) <= SAME_DISTANCE * place.distance;
}

// Weights of the four pixels around a place `t` of the way from the second to the third (Catmull and Rom 1974).
vec4 catmull_rom(float t) {
    return vec4(t * (-0.5 + t * (1.0 - 0.5 * t)), 1.0 + t * t * (-2.5 + 1.5 * t), t * (0.5 + t * (2.0 - 1.5 * t)),
                t * t * (-0.5 + 0.5 * t));
}

// By a cubic, where all sixteen pixels show the surface.
bool sharp(ivec2 low, vec2 part, TaaPlace place, out vec3 light) {
    vec4 across = catmull_rom(part.x);
    vec4 down = catmull_rom(part.y);
    light = vec3(0.0);
    for (int i = 0; i < 16; i++) {
        ivec2 at = low + ivec2(i & 3, i >> 2) - 1;
        if (!inside(at)) return false;
        uint index = index_of(at);
        if (!shows(index, place)) return false;
        light += across[i & 3] * down[i >> 2] * past_lights[index].radiance;
    }
    return true;
}

// The light of the past frame; false where it does not show what the pixel shows.
bool follow(uint pixel, out vec3 light) {
    light = vec3(0.0);
    TaaPlace place = taa_places[pixel];
    if (place.instance == LOST) return false;
    // Far outside, numbers would not fit into integers.
    vec2 from = clamp(place.at - 0.5, vec2(-4.0), vec2(push.width, push.height) + 4.0);
    vec2 nearest = floor(from + 0.5);
    bool exact = all(lessThan(abs(from - nearest), vec2(SAME_PLACE)));
    if (exact) from = nearest;
    ivec2 low = ivec2(floor(from));
    vec2 part = from - vec2(low);

    vec2 motion = vec2(0.0);
    float then = 0.0;
    float seen = 0.0;     // weight of the pixels that show the surface
    float followed = 0.0; // and of those whose motion is known
    for (int i = 0; i < 4; i++) {
        ivec2 corner = ivec2(i & 1, i >> 1);
        vec2 share = mix(1.0 - part, part, vec2(corner));
        float weight = share.x * share.y;
        if (weight <= 0.0 || !inside(low + corner)) continue;
        uint index = index_of(low + corner);
        if (!shows(index, place)) continue;
        TaaSeen s = past_seens[index];
        light += weight * past_lights[index].radiance;
        seen += weight;
        if (s.then < 0.0) continue;
        motion += weight * s.motion;
        then += weight * s.then;
        followed += weight;
    }
    if (seen < LEAST_WEIGHT) {
        taa_places[pixel].instance = LOST;
        return false;
    }
    light /= seen;
    vec3 cubic;
    if (!exact && seen > 0.999 && sharp(low, part, place, cubic)) light = cubic;
    bool lost = followed < LEAST_WEIGHT;
    taa_places[pixel] = lost ? TaaPlace(vec2(0.0), 0.0, LOST)
                             : TaaPlace(place.at - motion / followed, then / followed, place.instance);
    return true;
}
