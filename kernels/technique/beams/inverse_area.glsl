// Integrals of one over a beam's cross-section along a ray, in closed form (erratum 10): the area is a quadratic of the ray's
// parameter, so its inverse has an arctangent or a logarithm for its integral.
#include "technique/beams/interval.glsl"

const float INVERSE_ROOT_3 = 0.577350269;

// The area u metres beyond a place on the ray: constant + u (linear + u square), m2, turned so that it is positive there.
struct Area {
    float constant;
    float linear;
    float square;
};

Area area_round(Crossing c, float t) {
    float area = twice_area(c, t);
    float turn = area < 0.0 ? -0.5 : 0.5;
    return Area(turn * area, turn * (c.area.y + 2.0 * t * c.area.z), turn * c.area.z);
}

float area_over(Area area, float u) {
    return abs(area.constant + u * (area.linear + u * area.square));
}

// The angle of the point (x, y), y >= 0. GLSL's own is good to 2^-11 only.
float angle_of(float y, float x) {
    float size = sqrt(x * x + y * y);
    float half_tangent = x >= 0.0 ? y / (size + x) : (size - x) / y;
    float quarter = half_tangent / (1.0 + sqrt(1.0 + half_tangent * half_tangent));
    float w = quarter / (1.0 + sqrt(1.0 + quarter * quarter));
    float w2 = w * w;
    return 8.0 * w * (1.0 + w2 * (-1.0 / 3.0 + w2 * (0.2 + w2 * (-1.0 / 7.0 + w2 * (1.0 / 9.0 - w2 / 11.0)))));
}

// Integrals over [-extent, extent] of 1 / area and of u / area, which has no root there; areas below the floor count as
// it. The first is 2 extent / inner times atan(z) / z or atanh(z) / z, with inner = constant - square extent^2 and
// z = extent sqrt(|discriminant|) / inner: nothing cancels where the discriminant does, since z is small there.
vec2 inverse_moments(Area area, float extent, float floor_area) {
    const vec2 PLACES = vec2(0.861136312, 0.339981044);
    const vec2 WEIGHTS = vec2(0.347854845, 0.652145155);
    vec2 sums = vec2(0.0);
    for (uint i = 0u; i < 4u; i++) {
        float u = ((i & 1u) == 0u ? -1.0 : 1.0) * extent * PLACES[i / 2u];
        float part = WEIGHTS[i / 2u] * extent / max(area_over(area, u), floor_area);
        sums += vec2(part, part * u);
    }
    float inner = area.constant - area.square * extent * extent;
    float discriminant = area.linear * area.linear - 4.0 * area.square * area.constant;
    float size = extent * sqrt(abs(discriminant));
    float smallest = min(area_over(area, -extent), area_over(area, extent));
    float largest = max(area_over(area, -extent), area_over(area, extent));
    // So little variation leaves less than 1e-6.
    if (largest < 2.0 * smallest) return sums;
    if (smallest < floor_area || (discriminant >= 0.0 && !(inner > size))) return sums;
    float exact;
    if (inner > 0.0 && size < 0.1 * inner) {
        float z2 = -sign(discriminant) * (size / inner) * (size / inner);
        exact = 2.0 * extent / inner * (1.0 - z2 * (1.0 / 3.0 - 0.2 * z2));
    } else if (discriminant < 0.0) {
        exact = 2.0 * extent / size * angle_of(size, inner);
    } else {
        exact = extent / size * log((inner + size) / (inner - size));
    }
    return vec2(exact, sums.y);
}
