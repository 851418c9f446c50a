// A beam: the light between three rays that leave one specular surface and end at the next surface they meet. Points of it
// are origin + y * way of each corner, weighted by barycentrics; planes of equal y lie across the beam.

struct BeamCorner {
    vec3 origin; // m, on the plane y = 0, which all three share
    float start; // y where the edge leaves its surface
    vec3 way;    // the edge's direction, scaled so that its component along the beam's normal is 1
    float end;   // y where the edge ends
    vec3 area;   // m2, 1/m ... : a0 + a1 l + a2 l^2, signed: what the light round this corner covers, l metres from `start`
    float flux;  // W, mean of the channels, that crosses that area
};

struct Beam {
    BeamCorner corners[3];
    vec3 normal; // unit, across the plane y = 0, the way the light goes
    uint medium;
    vec3 flux;   // W, at the edges' starts
    uint flags;
};

// The edges do not end on one smooth surface: what is lit beyond the nearest end needs a look of its own.
const uint BEAM_STRADDLES = 1u;
// Nothing to draw: the slot is empty.
const uint BEAM_EMPTY = 2u;

struct BeamHeader {
    uint count; // beams in use
    uint padding0;
    uint padding1;
    uint padding2;
};
