// Heights and normals of a sheet under waves that travel, one invocation a vertex.
#include "shared/index.glsl"
#include "shared/vertex.glsl"
#include "animate/normal.glsl"
#include "animate/sine.glsl"

// What does not travel at a vertex: everything but the waves.
struct StillWater {
    float height; // m
    float slope_x;
    float slope_z;
};

// A wave at the time that is shown. Angles are parts of a turn in fixed point, which are exact and wrap.
struct TravellingWave {
    uvec2 along_x; // from a vertex to the next, 2^-32 and 2^-64 turns
    uvec2 along_z;
    uint phase; // at the first vertex, 2^-32 turns
    float amplitude; // m
    vec2 slope; // amplitude times wave vector
};

layout(set = 0, binding = 0, std430) buffer Vertices { Vertex vertices[]; };
layout(set = 0, binding = 1, std430) readonly buffer StillWaters { StillWater still[]; };
layout(set = 0, binding = 2, std430) readonly buffer TravellingWaves { TravellingWave waves[]; };
layout(push_constant) uniform WavesPush {
    uint first_vertex;
    uint columns; // of vertices
    uint rows;
    uint waves;
} push;

// 2^-32 turns over `count` vertices.
uint turns(uvec2 step, uint count) {
    uint high;
    uint low;
    umulExtended(step.y, count, high, low);
    return step.x * count + high;
}

void main() {
    uint index = linear_index();
    if (index >= push.columns * push.rows) return;
    uint column = index % push.columns;
    uint row = index / push.columns;
    float height = 0.0;
    vec2 slope = vec2(0.0);
    for (uint k = 0u; k < push.waves; k++) {
        TravellingWave wave = waves[k];
        float sine;
        float cosine;
        sine_cosine(wave.phase + turns(wave.along_x, column) + turns(wave.along_z, row), sine, cosine);
        height += wave.amplitude * sine;
        slope += wave.slope * cosine;
    }
    StillWater rest = still[index];
    slope += vec2(rest.slope_x, rest.slope_z);
    vertices[push.first_vertex + index].position.y = rest.height + height;
    vertices[push.first_vertex + index].normal = normal_of(slope);
}
