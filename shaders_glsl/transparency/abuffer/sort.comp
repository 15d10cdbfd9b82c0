#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/network.glsl"

// Sorts the pixels of one class: as many nodes as fit into registers.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) writeonly uniform uimage2D sorted;

#define STORE_SLOT(i) if (i < pixel.count) { \
    uvec4 texel = uvec4(slot_depth[i], uint(slot_key[i]) ^ 0x80000000u, slot_payload[i]); \
    imageStore(sorted, node_texel(pixel.place + i), texel); \
}

void main() {
    Pixel pixel;
    if (!short_pixel(work_index(), pixel)) {
        return;
    }
    uint node = pixel.first;
    uint left = pixel.count;
    EACH_SLOT(LOAD_SLOT)
    sort_slots();
    EACH_SLOT(STORE_SLOT)
}
