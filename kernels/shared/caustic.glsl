// What a per-sample technique leaves for the film.
layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };
layout(set = 2, binding = 3, std430) readonly buffer VisibleShades { VisibleShade visible_shades[]; };
layout(set = 2, binding = 12, std430) readonly buffer SampleIrradiance { vec4 sample_irradiance[]; };
layout(set = 2, binding = 20, std430) readonly buffer SampleVolume { vec4 sample_volume[]; };

struct CausticSample {
    vec3 irradiance; // W/m2, at the visible point
    vec3 radiance;   // W/(m2 sr), at the camera
};

// Dark where the sample saw no point or where the technique's value is not finite, which is counted.
CausticSample caustic_sample(uint slot) {
    CausticSample dark = CausticSample(vec3(0.0), vec3(0.0));
    if (visible_points[slot].instance == NO_INSTANCE) return dark;
    VisibleShade shade = visible_shades[slot];
    vec3 irradiance = sample_irradiance[slot].rgb;
    vec3 radiance = irradiance * shade.throughput * shade.albedo / PI;
    if (!all_finite(irradiance) || !all_finite(radiance)) {
        atomicAdd(counters.non_finite, 1u);
        return dark;
    }
    return CausticSample(irradiance, radiance);
}

// Caustic light that media scatter into this sample's path, W/(m2 sr) at the camera. Dark where nothing scatters, or where
// the technique's value is not finite, which is counted.
vec3 caustic_volume(uint slot) {
    if (view.segments == 0u) return vec3(0.0);
    vec3 radiance = sample_volume[slot].rgb;
    if (all_finite(radiance)) return radiance;
    atomicAdd(counters.non_finite, 1u);
    return vec3(0.0);
}
