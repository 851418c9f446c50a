// What the light round a ray covers, l metres along it.
struct RayArea {
    vec3 area;  // coefficients of 1, l, l^2; signed, m2
    float flux; // W that crosses that area
};

layout(set = 3, binding = 15, std430) buffer RayAreas { RayArea ray_areas[]; };
