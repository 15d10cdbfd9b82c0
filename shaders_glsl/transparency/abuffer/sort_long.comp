#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"

// Takes merged nodes to where short pixels have theirs.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) readonly uniform uimage2D even;
layout(set = 0, binding = 8, rgba32ui) readonly uniform uimage2D odd;
layout(set = 0, binding = 9, rgba32ui) writeonly uniform uimage2D sorted;

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    bool in_odd = (merges_of(pixel.count) & 1u) == 1u;
    // Eight nodes a turn: lavapipe 22 ends loops after 65,535.
    for (uint first = 0u; first < pixel.count; first += 8u) {
        for (uint done = first; done < min(first + 8u, pixel.count); ++done) {
            ivec2 at = node_texel(pixel.place + done);
            imageStore(sorted, at, in_odd ? imageLoad(odd, at) : imageLoad(even, at));
        }
    }
}
