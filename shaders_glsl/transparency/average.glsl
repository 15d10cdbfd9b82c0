// Layers that were only summed up, as one layer: their average colour, and all that they hide (McGuire and Bavoil 2013,
// equation 6). Premultiplied.
vec4 average_layer(vec3 colors, float alphas, float through) {
    float alpha = 1.0 - through;
    return vec4(colors / max(alphas, 1e-30) * alpha, alpha);
}
