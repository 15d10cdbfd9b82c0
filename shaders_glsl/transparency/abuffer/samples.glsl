// Samples of a pixel.
#ifndef TRANSPARENCY_ABUFFER_SAMPLES_GLSL
#define TRANSPARENCY_ABUFFER_SAMPLES_GLSL

layout(constant_id = 11) const uint SAMPLES = 1u;

// Where pixels have several samples, the lowest bits of a node's key are those that it is seen at.
const uint SAMPLE_BITS = 8u;

// Where a fragment is sorted, and at which samples of its pixel it is seen.
struct Covered {
    float depth;
    uint samples; // bit i: sample i
};

#endif
