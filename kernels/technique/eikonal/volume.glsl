// What is known of the volumes, one a light; EikonalVolume in renderer/technique/eikonal/device.rs.
#include "technique/eikonal/grid.glsl"
#include "technique/eikonal/path.glsl"

struct EikonalVolume {
    EikonalGrid grid;
    EikonalSource source;
    uint light_medium;
    uint wave_medium;
    uint band;     // cells below the surface whose values are given
    uint padding0;
};

layout(set = 3, binding = 0, std430) readonly buffer EikonalVolumes { EikonalVolume volumes[]; };
