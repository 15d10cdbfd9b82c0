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

void main() {
    Pixel pixel;
    if (!short_pixel(work_index(), pixel)) {
        return;
    }
    load_slots(pixel);
    sort_slots();
    [[unroll]] for (uint i = 0u; i < SLOTS; i++) {
        if (i < pixel.count) {
            imageStore(sorted, node_texel(pixel.place + i), slot_node(i));
        }
    }
}
