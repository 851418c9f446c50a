// Visible diffuse points: where a camera path ends. Two layers a pixel, one after the other: first what is seen directly
// or through refraction, then what the first interface reflects.

struct VisiblePoint {
    vec3 position;     // world space, just off the surface on the side that is seen: rays start here
    uint instance;     // NO_INSTANCE: the path ended without a diffuse point
    uint normal;       // packed, shading, on the side that is seen
    uint geometric;    // packed, on the side that is seen
    float footprint;   // metres that a pixel covers here, before curved surfaces magnify it
    uint medium;       // that the point is seen in
};

struct VisibleShade {
    vec3 throughput; // radiance at the camera over radiance that leaves the point
    float distance;  // metres along the path
    vec3 albedo;
    uint events;     // specular surfaces on the way
};

const uint VISIBLE_LAYERS = 2u;
