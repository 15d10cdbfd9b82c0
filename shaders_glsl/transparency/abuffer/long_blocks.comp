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

#define LOAD_PLACE(i) { \
    uint node = place + min(i, left - 1u); \
    uvec4 texel = LINKED ? imageLoad(flat_nodes, node_texel(node)) : node_at(node); \
    slot_depth[i] = i < left ? int(texel.x) : -1; \
    slot_key[i] = signed_key(texel.y); \
    slot_payload[i] = LINKED ? texel.zw : node_payload(node, texel); \
}

#define STORE_PLACE(i) if (i < left) { \
    uvec4 texel = uvec4(slot_depth[i], uint(slot_key[i]) ^ 0x80000000u, slot_payload[i]); \
    imageStore(sorted, node_texel(place + i), texel); \
}

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
    EACH_SLOT(LOAD_PLACE)
    sort_slots();
    EACH_SLOT(STORE_PLACE)
}
