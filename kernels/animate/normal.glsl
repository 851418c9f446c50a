// The unit normal, upward, of a surface with these slopes along x and z; of slopes that change places, turned alike.
vec3 normal_of(vec2 slope) {
    precise float square = slope.x * slope.x + slope.y * slope.y;
    return vec3(-slope.x, 1.0, -slope.y) * inversesqrt(1.0 + square);
}
