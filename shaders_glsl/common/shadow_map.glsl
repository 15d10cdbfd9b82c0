// Percentage-closer filtering of a shadow map array (Reeves et al. 1987): hardware 2×2 taps on a square grid.

// `taps` taps a side, one texel apart: 1 is the hardware's bilinear comparison alone. A specialisation constant: a
// software driver runs a loop whose end it does not know once more than needed, samples and all.
float percentage_closer(sampler2DArrayShadow map, vec3 uv_layer, float reference, uint taps, float texel) {
    float sum = 0.0;
    float first = 0.5 - 0.5 * float(taps);
    for (uint y = 0u; y < taps; ++y) {
        for (uint x = 0u; x < taps; ++x) {
            vec2 offset = (vec2(x, y) + first) * texel;
            sum += texture(map, vec4(uv_layer.xy + offset, uv_layer.z, reference));
        }
    }
    return sum / float(taps * taps);
}

// Lifts a receiver off its own shadow: along the normal, by what the plane rises within the filter's footprint, and a
// little towards the light. The footprint lies across the map's axis (unit length): a point of it v metres aside is
// nearer to the receiver's plane by at most |v| times the sine between normal and axis. `texel` is the size of a
// shadow-map texel at the receiver in metres. (Holbert 2011, "Saying goodbye to shadow acne", for parallel light.)
vec3 lift_receiver(vec3 position, vec3 normal, vec3 to_light, vec3 axis, float texel, uint taps) {
    // To the farthest texel centre that a bilinear tap reads: half the grid and half a texel more, along the diagonal.
    float radius = sqrt(2.0) * (0.5 * float(taps) + 0.5);
    float sine = length(cross(normal, axis));
    return position + normal * (radius * texel * sine) + to_light * (0.25 * texel);
}
