#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"

// Lengths of the lists.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) writeonly uniform image2D counts;
layout(set = 0, binding = 23, r32ui) readonly uniform uimage2D heads;

// Eight nodes a turn: lavapipe 22 ends loops after 65,535.
#define STEP if (node != NO_NODE) { \
    ++count; \
    node = node_after(node, node_at(node)); \
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(uvec2(pixel), abuffer.size)) || abuffer.used == 0u) {
        return;
    }
    uint node = imageLoad(heads, pixel).r;
    uint count = 0u;
    while (node != NO_NODE) {
        STEP STEP STEP STEP STEP STEP STEP STEP
    }
    imageStore(counts, pixel, vec4(float(count)));
}
