// From a visible point and a light to what is searched for.
#include "shared/index.glsl"
#include "shared/optics.glsl"
#include "shared/view.glsl"
#include "shared/visible.glsl"
#include "technique/mnee/facet.glsl"

layout(set = 2, binding = 2, std430) readonly buffer VisiblePoints { VisiblePoint visible_points[]; };

Query query_at(VisiblePoint point, Light light) {
    Query query;
    query.point = point.position;
    query.directional = light.kind == LIGHT_DIRECTIONAL;
    query.light = query.directional ? -light.direction : light.position - point.position;
    query.point_index = media[point.medium].index;
    query.light_index = media[light.medium].index;
    return query;
}
