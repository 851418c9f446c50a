// How much surface the texels of the camera's view stand for.
#include "technique/photons/store.glsl"

// By texel: where an edge is, the surface that it stands for over what it would cover alone, in AREA_UNITs, and AREA_EDGE.
layout(set = 3, binding = 20, std430) buffer CameraAreas { uint camera_areas[]; };

const uint AREA_EDGE = 0x80000000u;
const float AREA_UNIT = 1.0 / 1048576.0;
// Of its own area, the least that a texel is taken to stand for: all that photons bring is divided by it.
const float LEAST_PART = 1.0 / 32.0;

// Cosine to the surface below which its area is taken for what it is there: nearer to the horizon a texel covers more than
// its middle can say.
const float GRAZING = 0.02;

// m2 that a texel covers of the plane across the view at that depth.
float plane_area(LightView v, float depth) {
    vec2 step = (v.upper - v.lower) / vec2(v.columns - 1u, v.rows - 1u);
    return step.x * step.y * depth * depth;
}

// m2 of surface that a texel would cover, were it all as at `way`, which is 1 along the view (erratum 12).
float area_over(LightView v, vec3 way, vec3 geometric, float depth) {
    float cosine = max(abs(dot(geometric, way)), GRAZING * length(way));
    // This is A_plane (z / d) / |v.n|, since way = v d / z.
    return plane_area(v, depth) / cosine;
}

vec3 way_at(LightView v, vec2 chart) {
    return v.forward + chart.x * v.right + chart.y * v.up;
}

// m2 of the surface that is seen in its middle, over all of the texel.
float whole_area(LightView v, uint texel) {
    CameraTexel seen = camera_texels[texel];
    vec2 chart = chart_of(v, uvec2(texel % v.columns, texel / v.columns));
    return area_over(v, way_at(v, chart), unpack_direction(seen.geometric), seen.depth);
}

// m2 that the light of a texel is divided by.
float texel_area(LightView v, uint texel) {
    uint part = camera_areas[texel];
    float whole = whole_area(v, texel);
    return (part & AREA_EDGE) == 0u ? whole : whole * max(float(part & ~AREA_EDGE) * AREA_UNIT, LEAST_PART);
}
