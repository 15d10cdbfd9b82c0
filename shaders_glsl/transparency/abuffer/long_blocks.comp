#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/network.glsl"

// Sorts blocks of 16 nodes, an invocation a block. (A loop over the blocks of a pixel, with the network in it, is more
// than SwiftShader's compiler can take.)

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) writeonly uniform uimage2D sorted;
layout(set = 0, binding = 8, rgba32ui) readonly uniform uimage2D flat_nodes; // of lists

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    uint done = gl_WorkGroupID.z * SHORT;
    if (done >= pixel.count || sorted_in_place(pixel.count)) {
        return;
    }
    uint left = pixel.count - done;
    uint place = pixel.place + done;
    [[unroll]] for (uint i = 0u; i < SLOTS; i++) {
        uint node = place + min(i, left - 1u);
        uvec4 texel = LINKED ? imageLoad(flat_nodes, node_texel(node)) : node_at(node);
        slot_depth[i] = mix(-1, int(texel.x), i < left);
        slot_key[i] = signed_key(texel.y);
        slot_payload[i] = LINKED ? texel.zw : node_payload(node, texel);
    }
    sort_slots();
    [[unroll]] for (uint i = 0u; i < SLOTS; i++) {
        if (i < left) {
            imageStore(sorted, node_texel(place + i), slot_node(i));
        }
    }
}
