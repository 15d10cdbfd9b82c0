#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/network.glsl"
#include "transparency/abuffer/report.glsl"

// Composites the pixels of one class: as many nodes as fit into registers.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied

#define COMPOSITE(i) { \
    vec4 layer = node_color(slot_key[i], slot_payload[i]); \
    put_behind(front, i < pixel.count ? layer : vec4(0.0)); \
    clamped = clamped || (i < pixel.count && is_clamped(slot_payload[i])); \
}

void main() {
    uint place = work_index();
    const uint CLASS = SLOTS == 4u ? 0u : SLOTS == 8u ? 1u : 2u;
    if (place >= total.pixels[CLASS]) {
        return;
    }
    place += CLASS > 0u ? total.pixels[0] : 0u;
    place += CLASS > 1u ? total.pixels[1] : 0u;
    Pixel pixel = work[place];
    uint node = pixel.first;
    uint left = pixel.count;
    EACH_SLOT(LOAD_SLOT)
    sort_slots();
    vec4 front = vec4(0.0, 0.0, 0.0, 1.0);
    bool clamped = false;
    EACH_SLOT(COMPOSITE)
    if (clamped) {
        atomicAdd(report.clamped_pixels, 1u);
    }
    ivec2 at = pixel_of(pixel.index);
    imageStore(color, at, over_opaque(front, imageLoad(color, at)));
}
