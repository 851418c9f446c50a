// Differences against the wave, as in renderer/technique/eikonal/marching.rs. Written out axis by axis: on llvmpipe loops with
// indexed vectors took five times as long.

// An upwind neighbour's value and weight; of second order where the one behind it is lower still.
vec2 upwind_term(float near, float behind) {
    return behind <= near && near < UNKNOWN ? vec2((4.0 * near - behind) / 3.0, 2.25) : vec2(near, 1.0);
}

void order_terms(inout vec2 first, inout vec2 second) {
    vec2 low = first.x <= second.x ? first : second;
    second = first.x <= second.x ? second : first;
    first = low;
}

// The phi for which weight (phi - value)^2, summed over the axes whose values lie below it, is `square`. Terms: value, weight.
float upwind(vec2 a, vec2 b, vec2 c, float square) {
    order_terms(a, b);
    order_terms(b, c);
    order_terms(a, b);
    if (a.x >= UNKNOWN) return UNKNOWN;
    // About the least value nothing large is subtracted.
    float rise_b = b.x - a.x;
    float rise_c = c.x - a.x;
    float above = sqrt(square / a.y);
    if (rise_b >= above) return a.x + above;
    vec3 moments = vec3(a.y, 0.0, 0.0) + b.y * vec3(1.0, rise_b, rise_b * rise_b);
    float root = moments.y * moments.y - moments.x * (moments.z - square);
    if (root < 0.0) return a.x + above;
    above = (moments.y + sqrt(root)) / moments.x;
    if (rise_c >= above) return a.x + above;
    moments += c.y * vec3(1.0, rise_c, rise_c * rise_c);
    root = moments.y * moments.y - moments.x * (moments.z - square);
    if (root < 0.0) return a.x + above;
    return a.x + (moments.y + sqrt(root)) / moments.x;
}
