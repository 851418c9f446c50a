// Differences against the wave, as in renderer/technique/eikonal/marching.rs.

// The phi for which weight (phi - value)^2, summed over the axes whose values lie below it, is `square`.
float upwind(vec3 value, vec3 weight, float square) {
    for (int i = 0; i < 3; i++) {
        // 0 and 1, 1 and 2, 0 and 1 again.
        int k = i & 1;
        if (value[k] <= value[k + 1]) continue;
        float swap = value[k];
        value[k] = value[k + 1];
        value[k + 1] = swap;
        swap = weight[k];
        weight[k] = weight[k + 1];
        weight[k + 1] = swap;
    }
    if (value.x >= UNKNOWN) return UNKNOWN;
    float above = UNKNOWN;
    vec3 moments = vec3(0.0);
    for (int i = 0; i < 3; i++) {
        float rise = value[i] - value.x;
        if (value[i] >= UNKNOWN || rise >= above) break;
        moments += weight[i] * vec3(1.0, rise, rise * rise);
        float root = moments.y * moments.y - moments.x * (moments.z - square);
        if (root < 0.0) break;
        above = (moments.y + sqrt(root)) / moments.x;
    }
    return value.x + above;
}
