// Sums up layers with weights that fall with distance (McGuire and Bavoil 2013, "Weighted blended order-independent
// transparency").
#include "transparency/distance.glsl"
#include "transparency/sums.glsl"

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint EQUATION = 7u;

// The paper's weights, by the number of their equation, for alpha 1.
float layer_weight(float depth) {
    float z = abs(layer_distance(depth));
    if (EQUATION == 10u) {
        return max(1e-2, 3e3 * depth * depth * depth); // depth is reversed
    }
    float far = pow(z / 200.0, 6.0);
    float raw = EQUATION == 7u ? 10.0 / (1e-5 + pow(z / 5.0, 2.0) + far)
        : EQUATION == 8u ? 10.0 / (1e-5 + pow(z / 10.0, 3.0) + far)
        : 0.03 / (1e-5 + pow(z / 200.0, 4.0));
    return clamp(raw, 1e-2, 3e3);
}

void weigh(vec4 color) {
    add_layer(color, color.a * layer_weight(gl_FragCoord.z));
}
