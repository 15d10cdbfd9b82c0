// Sums up layers, each weighted by what the layers before it let through, as far as four moments of absorbance tell
// (Münstermann et al. 2018, section 3.2; Peters and Klein 2015, "Moment shadow mapping", algorithm 1).
#include "transparency/moments/depth.glsl"
#include "transparency/sums.glsl"

layout(early_fragment_tests) in;

layout(set = 0, binding = 22) uniform texture2D moments;
layout(set = 0, binding = 23) uniform texture2D absorbance;

// Moments of floats of 32 bits are moved this far towards those of a distribution that is well conditioned.
const float BIAS = 5e-7;
const vec4 BIAS_MOMENTS = vec4(0.0, 0.375, 0.0, 0.375);
// What rounding must not take to 0: divisors.
const float LEAST = 1e-10;
// From the least to the greatest absorbance that the moments allow.
const float OVERESTIMATION = 0.25;

// Share of the absorbance before z: bounds from the distribution on z and two other depths that has the moments `b`.
float absorbed_before(vec4 b, float z) {
    b = mix(b, BIAS_MOMENTS, BIAS);
    // The matrix of moments (1, b1, b2; b1, b2, b3; b2, b3, b4) as L D Lᵀ.
    float d1 = b.y - b.x * b.x;
    float l21d1 = b.z - b.x * b.y;
    float l21 = l21d1 / d1;
    float d2 = max((b.w - b.y * b.y) - l21d1 * l21, LEAST);
    // It times c is (1, z, z²); c0 + c1 x + c2 x² is 0 at the other two depths.
    float y1 = z - b.x;
    float y2 = z * z - b.y - l21 * y1;
    float c2 = y2 / d2;
    c2 = abs(c2) < LEAST ? LEAST : c2;
    float c1 = y1 / d1 - l21 * c2;
    float c0 = 1.0 - b.x * c1 - b.y * c2;
    float p = 0.5 * c1 / c2;
    float root = sqrt(max(p * p - c0 / c2, 0.0));
    float nearer = -p - root;
    float farther = -p + root;
    // The polynomial through 1 where a depth is before z, 0 where it is behind, and the overestimation at z.
    float at_nearer = nearer < z ? 1.0 : 0.0;
    float at_farther = farther < z ? 1.0 : 0.0;
    float slope = (at_nearer - OVERESTIMATION) / (nearer - z);
    float next = (at_farther - at_nearer) / (farther - nearer);
    float curve = (next - slope) / (farther - z);
    // Its mean over the distribution: in x, x² by the moments.
    float constant = OVERESTIMATION - slope * z + curve * z * nearer;
    float linear = slope - curve * (z + nearer);
    return clamp(constant + linear * b.x + curve * b.y, 0.0, 1.0);
}

void add_seen(vec4 color) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    float whole = texelFetch(absorbance, pixel, 0).r;
    vec4 b = texelFetch(moments, pixel, 0) / max(whole, 1e-30);
    float through = whole > 0.0 ? exp(-whole * absorbed_before(b, moment_depth(gl_FragCoord.z))) : 1.0;
    add_layer(color, through);
}
