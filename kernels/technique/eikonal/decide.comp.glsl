// What further sweeps have to do. Where cells have not settled, waves bend light against the order of the first sweep, towards
// the foot or past it: all columns about as far from the foot are visited again.
#include "shared/index.glsl"
#include "technique/eikonal/checks.glsl"

layout(push_constant) uniform DecidePush {
    ivec2 columns;
    ivec2 foot;
    int margin; // columns
    uint padding0;
} push;

void main() {
    if (linear_index() != 0u) return;
    bool more = checks.unsettled > 0u;
    ivec2 reach = ivec2(checks.reach_u, checks.reach_v) + push.margin;
    ivec2 lower = clamp(push.foot - reach, ivec2(0), push.columns);
    ivec2 size = clamp(push.foot + reach + 1, ivec2(0), push.columns) - lower;
    if (!more) size = ivec2(0);
    checks.lower_u = uint(lower.x);
    checks.lower_v = uint(lower.y);
    checks.size_u = uint(size.x);
    checks.size_v = uint(size.y);
    // Groups of 64 as in shared/index.glsl; the columns of any grid that fits a buffer are fewer than 65535 of them.
    checks.groups[0] = uint(size.x * size.y + 63) / 64u;
    checks.groups[1] = more ? 1u : 0u;
    checks.groups[2] = more ? 1u : 0u;
}
