#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "common/views.glsl"
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"

// The next layer of each pixel, nearest first: of the nodes behind the last one, the one in front.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) writeonly uniform image2D color; // premultiplied
layout(set = 0, binding = 6, r32f) writeonly uniform image2D distance_image; // along the view axis, metres
layout(set = 0, binding = 7, rg32ui) uniform uimage2D last; // depth and key of the last layer

void main() {
    uint place = work_index();
    if (place >= work_count()) {
        return;
    }
    Pixel pixel = work[place];
    ivec2 at = pixel_at(pixel);
    uvec4 before = imageLoad(last, at);
    uint node = pixel.first;
    uint left = pixel.count;
    // Nodes are nearer than depth 0: what they passed is nowhere behind that.
    uvec4 found = uvec4(0u);
    uint found_node = 0u;
    while (left > 0u) {
        // Eight nodes a turn: lavapipe 22 ends loops after 65,535.
        for (uint i = 0u; i < 8u; i++) {
            if (left > 0u) {
                uvec4 texel = node_at(node);
                bool next = in_front(before, texel) && in_front(texel, found);
                found = next ? texel : found;
                found_node = next ? node : found_node;
                node = node_after(node, texel);
                --left;
            }
        }
    }
    imageStore(last, at, found);
    if (found.x == 0u) {
        return;
    }
    Layer layer = node_layer(signed_key(found.y), node_payload(found_node, found));
    // Averaged over the pixel's samples.
    float share = SAMPLES > 1u ? float(bitCount(node_samples(found.y))) / float(SAMPLES) : 1.0;
    imageStore(color, at, vec4(layer.rgb, layer.alpha) * share);
    float depth = uintBitsToFloat(found.x);
    imageStore(distance_image, at, vec4(-view_position(0u, vec2(at) + 0.5, depth).z));
}
