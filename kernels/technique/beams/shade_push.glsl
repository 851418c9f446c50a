struct ShadePush {
    float light_angle; // radians that the light subtends where it is seen through the specular surfaces, at least
    uint smooth_area;  // 1: the area function is interpolated between corners, 0: it is the beam's own
    uint shadows;      // SHADOW_POINTS or SHADOW_EDGES
    float soft;        // m before a surface within which volume light fades, 0 for none
};
