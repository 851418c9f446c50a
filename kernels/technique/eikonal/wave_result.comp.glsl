// What the wave has left in each cell as light: over what flat water would leave, to a power (Mercier's section 4.1), times the
// light just below the surface there. A column an invocation.
#include "shared/index.glsl"
#include "technique/eikonal/wave.glsl"

layout(set = 3, binding = 1, std430) readonly buffer EikonalValues { uint values[]; };
layout(set = 3, binding = 6, std430) writeonly buffer EikonalLights { float lights[]; };
layout(set = 3, binding = 9, std430) readonly buffer WaveSums { float sums[]; };
layout(set = 3, binding = 11, std430) readonly buffer WaveAmplitudes { float amplitudes[]; };
layout(push_constant) uniform WaveResultPush {
    WaveGrid grid;
    float scale;    // light for which the amplitude is 1
    float flat_sum; // what flat water's wave leaves where its light is 1
    float root;     // of light, the power that sums go by
    float gain;
    float power;
} push;

void main() {
    WaveGrid grid = push.grid;
    uint column = linear_index();
    if (column >= grid.cells.x * grid.cells.y) return;
    ivec3 at = ivec3(column % grid.cells.x, column / grid.cells.x, 0);
    int from = wave_index(grid, at + ivec3(grid.border, grid.border, grid.top));
    int step = wave_pitch(grid).x * wave_pitch(grid).y;
    float light = 0.0;
    for (; at.z < int(grid.cells.z); at.z++) {
        int cell = volume_index(grid, at);
        uint known = values[cell];
        if (light == 0.0 && (known & GIVEN) != 0u) light = push.scale * amplitudes[from] * amplitudes[from];
        float sum = max(sums[from], 0.0) / push.flat_sum;
        // Where the wave came in as strong as the light, flat water's sum goes with it.
        float part = push.root > 0.0 ? sum / max(pow(light, push.root), 1e-30) : sum;
        bool lit = light > 0.0 && known != floatBitsToUint(OUTSIDE);
        lights[cell] = lit ? light * push.gain * pow(part, push.power) : UNLIT;
        from += step;
    }
}
