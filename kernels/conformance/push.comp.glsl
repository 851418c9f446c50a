// Writes down all push constants that every device offers: 128 bytes.
layout(local_size_x = 32) in;

layout(set = 3, binding = 0, std430) writeonly buffer Words { uint words[]; };
layout(push_constant) uniform PushedWords { uint pushed[32]; };

void main() {
    words[gl_LocalInvocationID.x] = pushed[gl_LocalInvocationID.x];
}
