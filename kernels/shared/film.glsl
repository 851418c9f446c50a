// Sums over samples. Two layers a pixel as the visible points have; index = layer * pixels + pixel.
layout(set = 2, binding = 6, std430) buffer FilmDirect { vec4 film_direct[]; };     // rgb radiance, W/(m2 sr)
layout(set = 2, binding = 7, std430) buffer FilmAlbedo { vec4 film_albedo[]; };     // rgb, w: samples with a point
layout(set = 2, binding = 8, std430) buffer FilmNormal { vec4 film_normal[]; };     // xyz, w: distance in m

// Values that were not finite and were left out, and paths given up; nothing fails silently.
struct FrameCounters {
    uint non_finite;
    uint too_long;   // camera paths with more specular events than are followed
    uint wrong_side; // camera paths that shading normals bent across the surface
    uint stretches;  // camera paths with more stretches in media that scatter than are kept
};
layout(set = 2, binding = 9, std430) buffer Counters { FrameCounters counters; };
