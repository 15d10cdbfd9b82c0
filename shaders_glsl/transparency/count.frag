#version 460

// Counts the fragments of each pixel by blending: exact up to 2^24.

layout(early_fragment_tests) in;

layout(location = 0) out float count;

void main() {
    count = 1.0;
}
