// Optical paths from a light through one triangle. The path is convex along a plane and along a line, so that each has one
// shortest: where it lies outside the triangle, the triangle's own is on an edge that it is beyond.

const uint SOURCE_POINT = 0u;
const uint SOURCE_DIRECTIONAL = 1u;
const uint SOURCE_SURFACE = 2u;

struct EikonalSource {
    vec3 place;     // of a point light; unit direction of a directional one
    uint kind;
    vec3 reference; // where the path is 0, so that little is lost to rounding far from the light; nearer to it than the grid
    float index;    // refractive index on the light's side
};

float path_to(EikonalSource source, vec3 at) {
    if (source.kind == SOURCE_SURFACE) return 0.0;
    vec3 from = at - source.reference;
    if (source.kind == SOURCE_DIRECTIONAL) return source.index * dot(source.place, from);
    vec3 a = at - source.place;
    vec3 b = source.reference - source.place;
    // |a| - |b| without the difference of two large numbers.
    return source.index * dot(from, a + b) / max(length(a) + length(b), 1e-20);
}

// The gradient of path_to.
vec3 way_at(EikonalSource source, vec3 at) {
    if (source.kind == SOURCE_SURFACE) return vec3(0.0);
    if (source.kind == SOURCE_DIRECTIONAL) return source.index * source.place;
    vec3 a = at - source.place;
    return source.index * a / max(length(a), 1e-20);
}

const int PATH_TURNS = 8;

// Where light from `height` above a line to `depth` below crosses it, `across` apart along the line: m from the foot of what
// is below. Newton's method on Snell's law, whose slope never falls, kept within what is known.
float crossing(float height, float depth, float across, float above, float below) {
    if (depth < 1e-9 || across <= 0.0) return 0.0;
    float low = 0.0;
    float high = across;
    float hypotenuse = sqrt(height * height + across * across);
    float sine = min(above * across / (below * hypotenuse), 0.99);
    float t = min(depth * sine * inversesqrt(1.0 - sine * sine), across);
    for (int i = 0; i < PATH_TURNS; i++) {
        float left = across - t;
        float a = inversesqrt(height * height + left * left);
        float b = inversesqrt(depth * depth + t * t);
        float slope = below * t * b - above * left * a;
        if (slope < 0.0) low = t;
        else high = t;
        float steep = below * depth * depth * b * b * b + above * height * height * a * a * a;
        float next = t - slope / max(steep, 1e-20);
        bool inside = next > low && next < high;
        next = inside ? next : 0.5 * (low + high);
        if (abs(next - t) <= 1e-6 * depth) return next;
        t = next;
    }
    return t;
}

// The shortest path's way along a line or plane whose unit tangent towards the light is `along`, from the foot of `to`.
float way_along(EikonalSource source, vec3 along, vec3 foot, float depth, float below) {
    if (source.kind == SOURCE_SURFACE) return 0.0;
    if (source.kind == SOURCE_DIRECTIONAL) {
        float slope = -source.index * dot(source.place, along);
        float left = below * below - slope * slope;
        return slope * depth * inversesqrt(max(left, 1e-6));
    }
    vec3 to_light = source.place - foot;
    float across = dot(to_light, along);
    float height = sqrt(max(dot(to_light, to_light) - across * across, 0.0));
    return across < 0.0 ? -crossing(height, depth, -across, source.index, below)
                        : crossing(height, depth, across, source.index, below);
}

struct EikonalPath {
    float value; // m times index
    vec3 at;     // where it crosses
};

EikonalPath path_by(EikonalSource source, vec3 at, vec3 to, float below) {
    return EikonalPath(path_to(source, at) + below * length(to - at), at);
}

EikonalPath path_over_edge(EikonalSource source, vec3 a, vec3 b, vec3 to, float below) {
    float size = length(b - a);
    vec3 along = (b - a) / max(size, 1e-20);
    float foot = dot(to - a, along);
    vec3 beside = a + foot * along;
    float t = foot + way_along(source, along, beside, length(to - beside), below);
    return path_by(source, a + clamp(t, 0.0, size) * along, to, below);
}

// The shortest to `to` through the triangle with unit normal `normal`.
EikonalPath path_through(EikonalSource source, vec3 a, vec3 b, vec3 c, vec3 normal, vec3 to, float below) {
    float depth = dot(to - a, normal);
    vec3 foot = to - depth * normal;
    vec3 across = source.kind == SOURCE_POINT ? source.place - foot : -source.place;
    across -= normal * dot(across, normal);
    float size = length(across);
    vec3 at = foot;
    if (size > 1e-12) {
        vec3 along = across / size;
        at += along * way_along(source, along, foot, abs(depth), below);
    }
    vec3 outside = vec3(dot(cross(b - a, at - a), normal), dot(cross(c - b, at - b), normal), dot(cross(a - c, at - c), normal));
    if (all(greaterThanEqual(outside, vec3(0.0)))) return path_by(source, at, to, below);
    EikonalPath best = EikonalPath(1.0e38, at);
    for (int edge = 0; edge < 3; edge++) {
        if (outside[edge] >= 0.0) continue;
        vec3 from = edge == 0 ? a : edge == 1 ? b : c;
        vec3 end = edge == 0 ? b : edge == 1 ? c : a;
        EikonalPath path = path_over_edge(source, from, end, to, below);
        if (path.value < best.value) best = path;
    }
    return best;
}
