// What the light round a ray covers, l metres along it, and what of it the beams there carry.
struct RayArea {
    vec3 area;  // coefficients of 1, l, l^2; signed, m2
    float flux; // W that crosses that area
    float gain; // all light round the ray over what goes through beams that are drawn; 0 where none is
    uint padding0;
    uint padding1;
    uint padding2;
};

layout(set = 3, binding = 15, std430) buffer RayAreas { RayArea ray_areas[]; };
