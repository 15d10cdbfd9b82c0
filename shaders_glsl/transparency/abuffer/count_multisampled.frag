#version 460

// Counts the fragments of each pixel, each once, at however many of its samples it is seen.

layout(early_fragment_tests) in;

layout(set = 0, binding = 22, r32ui) uniform uimage2D fragment_counts;

void main() {
    imageAtomicAdd(fragment_counts, ivec2(gl_FragCoord.xy), 1u);
}
