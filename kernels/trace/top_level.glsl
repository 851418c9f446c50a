// The level over the instances: a small tree in depth-first order, walked without a stack.
// Who includes this has declared trace_mesh(root, ray, instance, any_hit, found).

struct TopNode { // world space
    vec3 low;
    uint skip; // where to go on when the box is missed
    vec3 high;
    uint instance; // NO_INSTANCE for an inner node
    uint root; // of the mesh's tree, into the nodes
    uint mask; // of the instance, or of all below
    uint padding0;
    uint padding1;
};

layout(set = 1, binding = 2, std430) readonly buffer TraceTop { TopNode trace_top[]; };

// A few roundings, relative to the origin's largest coordinate: what its transform to object space may be off by.
const float TOP_MARGIN = 2e-6;

bool hits_top_node(TopNode node, Ray ray, vec3 inverse) {
    float margin = TOP_MARGIN * max(abs(ray.origin.x), max(abs(ray.origin.y), abs(ray.origin.z)));
    vec3 at_low = (node.low - margin - ray.origin) * inverse;
    vec3 at_high = (node.high + margin - ray.origin) * inverse;
    vec3 enter = min(at_low, at_high);
    vec3 leave = max(at_low, at_high);
    float first = max(max(enter.x, enter.y), max(enter.z, ray.t_min));
    float last = min(min(leave.x, leave.y), min(leave.z, ray.t_max));
    return first <= last + TOP_MARGIN * abs(last);
}

Hit trace_scene(Ray ray, uint mask, bool any_hit) {
    // Scaled by a power of two until its largest component is in [1, 2): exact, and no inverse overflows.
    vec3 size = abs(ray.direction);
    uint exponent = floatBitsToUint(max(size.x, max(size.y, size.z))) >> 23;
    exponent = clamp(exponent, 1u, 253u);
    float scale = uintBitsToFloat((254u - exponent) << 23);
    float inverse_scale = uintBitsToFloat(exponent << 23);
    Ray world = Ray(ray.origin, ray.t_min * inverse_scale, ray.direction * scale, ray.t_max * inverse_scale);

    vec3 inverse = finite_inverse(world.direction);
    Candidate found = Candidate(0u, NO_INSTANCE, vec2(0.0));
    uint count = trace_top[0].skip; // of all nodes: the root's
    for (uint at = 0u; at < count;) {
        TopNode node = trace_top[at];
        bool enter = (node.mask & mask) != 0u && hits_top_node(node, world, inverse);
        if (enter && node.instance != NO_INSTANCE) {
            ObjectRay object = object_ray(instances[node.instance], world);
            trace_mesh(node.root, node.instance, any_hit, object, found);
            world.t_max = object.t_max;
        }
        at = enter ? at + 1u : max(node.skip, at + 1u);
        if (any_hit && found.instance != NO_INSTANCE) {
            break;
        }
    }
    if (found.instance == NO_INSTANCE) {
        return no_hit(ray);
    }
    return Hit(world.t_max * scale, found.instance, trace_triangles[found.triangle].primitive, found.barycentrics);
}
