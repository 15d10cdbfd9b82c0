#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "common/views.glsl"
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"

// How far the nearest layer of each pixel is.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, r32f) writeonly uniform image2D front; // along the view axis, metres

void main() {
    uint place = work_index();
    if (place >= work_count()) {
        return;
    }
    Pixel pixel = work[place];
    uint node = pixel.first;
    uint left = pixel.count;
    float depth = 0.0;
    while (left > 0u) {
        // Eight nodes a turn: lavapipe 22 ends loops after 65,535.
        for (uint i = 0u; i < 8u; i++) {
            if (left > 0u) {
                uvec4 texel = node_at(node);
                depth = max(depth, uintBitsToFloat(texel.x));
                node = node_after(node, texel);
                --left;
            }
        }
    }
    ivec2 at = pixel_at(pixel);
    imageStore(front, at, vec4(-view_position(0u, vec2(at) + 0.5, depth).z));
}
