#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/network.glsl"

// Sorts blocks of 16 nodes.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) writeonly uniform uimage2D sorted;

#define STORE(i) if (i < left) { \
    uvec4 texel = uvec4(slot_depth[i], uint(slot_key[i]) ^ 0x80000000u, slot_payload[i]); \
    imageStore(sorted, node_texel(to + i), texel); \
}

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    uint node = pixel.first;
    for (uint done = 0u; done < pixel.count; done += SHORT) {
        uint left = pixel.count - done;
        uint to = pixel.place + done;
        EACH_SLOT(LOAD_SLOT)
        sort_slots();
        EACH_SLOT(STORE)
    }
}
