// Tracing by the device's own ray queries.

#extension GL_EXT_ray_query : require

layout(set = 1, binding = 0) uniform accelerationStructureEXT top_level;

// All geometry is opaque, so that one step is the whole query; a driver that wants more may have them, but not for ever.
const uint MAX_STEPS = 4096u;

Hit trace_scene(Ray ray, uint mask, bool any_hit) {
    uint flags = gl_RayFlagsOpaqueEXT | (any_hit ? gl_RayFlagsTerminateOnFirstHitEXT : 0u);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, top_level, flags, mask, ray.origin, ray.t_min, ray.direction, ray.t_max);
    for (uint i = 0u; i < MAX_STEPS && rayQueryProceedEXT(query); ++i) {
    }
    if (rayQueryGetIntersectionTypeEXT(query, true) != gl_RayQueryCommittedIntersectionTriangleEXT) {
        return no_hit(ray);
    }
    return Hit(rayQueryGetIntersectionTEXT(query, true),
               uint(rayQueryGetIntersectionInstanceCustomIndexEXT(query, true)),
               uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)),
               rayQueryGetIntersectionBarycentricsEXT(query, true));
}
