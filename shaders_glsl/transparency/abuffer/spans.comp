#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"

// Where each pixel's sorted nodes are, and between which depths.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D spans; // first, count, nearest, farthest
layout(set = 0, binding = 7, rgba32ui) readonly uniform uimage2D sorted;

void main() {
    uint place = work_index();
    if (place >= work_count()) {
        return;
    }
    Pixel pixel = work[place];
    float nearest = uintBitsToFloat(imageLoad(sorted, node_texel(pixel.place)).x);
    float farthest = uintBitsToFloat(imageLoad(sorted, node_texel(pixel.place + pixel.count - 1u)).x);
    imageStore(spans, pixel_at(pixel), vec4(pixel.place, pixel.count, nearest, farthest));
}
