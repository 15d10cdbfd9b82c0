#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"
#include "transparency/abuffer/nodes_read.glsl"

// Takes the nodes of long lists to where arrays have them.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) writeonly uniform uimage2D flat_nodes;

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel) || sorted_in_place(pixel.count)) {
        return;
    }
    uint node = pixel.first;
    uint done = 0u;
    while (done < pixel.count) {
        // Eight nodes a turn: lavapipe 22 ends loops after 65,535.
        for (uint i = 0u; i < 8u; i++) {
            if (done < pixel.count) {
                uvec4 texel = node_at(node);
                imageStore(flat_nodes, node_texel(pixel.place + done), uvec4(texel.xy, node_payload(node, texel)));
                node = node_after(node, texel);
                ++done;
            }
        }
    }
}
