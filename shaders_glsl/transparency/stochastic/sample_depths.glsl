// Each pixel has samples; a layer covers a random share of them, as large as its alpha, and each sample keeps the
// nearest layer that covers it (Enderton, Sintorn, Shirley and Luebke 2010, "Stochastic transparency", section 3). The
// numbers follow from pixel and triangle alone: the same picture each time, whatever the order of draws.

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint SAMPLES = 8u;

layout(set = 0, binding = 22, r32ui) uniform uimage2DArray sample_depths; // a layer a sample

// The next number of a sequence (Jarzynski and Olano 2020, "Hash functions for GPU rendering": PCG).
uint next_random(inout uint state) {
    state = state * 747796405u + 2891336453u;
    uint word = ((state >> ((state >> 28) + 4u)) ^ state) * 277803737u;
    return (word >> 22) ^ word;
}

void sample_depth(float alpha, uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint state = uint(pixel.x) * 73856093u ^ uint(pixel.y) * 19349663u ^ key * 83492791u;
    next_random(state);
    // As many samples as alpha says, rounded up or down at random.
    precise float share = alpha * float(SAMPLES) + float(next_random(state) >> 8) / 16777216.0;
    uint wanted = min(uint(share), SAMPLES);
    uint depth = floatBitsToUint(gl_FragCoord.z);
    // That many of all, each choice as likely (Knuth, The Art of Computer Programming 2, algorithm 3.4.2S).
    for (uint i = 0u; i < SAMPLES; ++i) {
        bool chosen = next_random(state) % (SAMPLES - i) < wanted;
        if (chosen) {
            imageAtomicMax(sample_depths, ivec3(pixel, i), depth);
        }
        wanted -= uint(chosen);
    }
}
