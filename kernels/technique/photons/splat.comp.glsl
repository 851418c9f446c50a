// Draws landed photons as discs (point splatting): spreads the flux of each over the texels round its place that show its
// surface. What one texel gives to another goes by the smaller of both areas, and what would go to texels that show something
// else stays: no flux is lost, and even light stays even up to edges. One invocation a photon.
#include "technique/photons/area.glsl"
#include "technique/photons/photon.glsl"

layout(push_constant) uniform SplatPush {
    uint camera;     // index of the camera's view
    uint photons;
    float flux_unit; // W
    float radius;    // of the discs, texels
} push;

// Silverman's biweight, of no account how high.
float biweight(vec2 apart) {
    float left = max(1.0 - dot(apart, apart) / (push.radius * push.radius), 0.0);
    return left * left;
}

void add_units(uint texel, uvec3 units) {
    for (uint c = 0u; c < 3u; c++) {
        if (units[c] > 0u) atomicAdd(photon_flux[3u * texel + c], units[c]);
    }
}

void main() {
    uint index = linear_index();
    if (index >= push.photons) return;
    PhotonRecord record = photon_records[index];
    if (mean(record.flux) <= 0.0 || medium_of(record) != LANDED) return;
    LightView v = light_views[push.camera];
    uint own = record.direction;
    CameraTexel seen = camera_texels[own];
    vec4 at = place_of(v, record.origin - v.origin);
    vec2 place = at.xy / at.z;
    float width = texel_width(v, at.w);
    float area = texel_area(v, own);
    Spot spot = Spot(record.origin, seen.instance, unpack_direction(seen.geometric));
    vec2 low = floor(place - push.radius);
    uvec2 size = uvec2(floor(place + push.radius) - low) + 1u;
    float sum = 0.0;
    for (uint i = 0u; i < size.x * size.y; i++) {
        sum += biweight(low + vec2(i % size.x, i / size.x) + 0.5 - place);
    }
    uvec3 units = units_of(record.flux, push.flux_unit);
    uvec3 left = units;
    for (uint i = 0u; i < size.x * size.y; i++) {
        vec2 texel = low + vec2(i % size.x, i / size.x);
        float weight = biweight(texel + 0.5 - place);
        if (weight <= 0.0 || !inside_view(v, texel)) continue;
        uint other = uint(texel.y) * v.columns + uint(texel.x);
        if (other == own || !shows(v, uvec2(texel), spot, width)) continue;
        weight *= min(texel_area(v, other) / area, 1.0) / sum;
        uvec3 part = min(uvec3(vec3(units) * weight + 0.5), left);
        left -= part;
        add_units(other, part);
    }
    add_units(own, left);
}
