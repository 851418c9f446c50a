// One level of a view's pyramid of depths from the level below, for any size: a node at the border has what is there.
#include "technique/photons/spaces.glsl"

layout(push_constant) uniform PyramidPush {
    uint view;
    uint level;
    uint padding0;
    uint padding1;
} push;

void main() {
    LightView v = light_views[push.view];
    uvec2 size = size_at(v, push.level);
    uint index = linear_index();
    if (index >= size.x * size.y) return;
    uvec2 node = uvec2(index % size.x, index / size.x);
    uvec2 last = size_at(v, push.level - 1u) - 1u;
    vec2 slab = vec2(NOTHING, 0.0);
    for (uint child = 0u; child < 4u; child++) {
        uvec2 at = min(2u * node + uvec2(child & 1u, child >> 1), last);
        vec2 found = depth_slabs[slab_index(v, push.view, push.level - 1u, at)];
        slab = vec2(min(slab.x, found.x), max(slab.y, found.y));
    }
    depth_slabs[slab_index(v, push.view, push.level, node)] = slab;
}
