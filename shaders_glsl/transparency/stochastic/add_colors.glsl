// Sums up layers, each as visible as the share of samples that keep nothing nearer (Enderton et al. 2010, section 4:
// the depth-based estimate; the resolve's average is its alpha correction).
#include "transparency/sums.glsl"

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint SAMPLES = 8u;

layout(set = 0, binding = 22, r32ui) readonly uniform uimage2DArray sample_depths; // a layer a sample

void add_visible(vec4 color) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint depth = floatBitsToUint(gl_FragCoord.z);
    uint seen = 0u;
    for (uint i = 0u; i < SAMPLES; ++i) {
        seen += uint(imageLoad(sample_depths, ivec3(pixel, i)).r <= depth);
    }
    add_layer(color, float(seen) / float(SAMPLES));
}
