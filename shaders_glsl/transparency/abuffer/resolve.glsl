#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/network.glsl"
#include "transparency/abuffer/gather_samples.glsl"
#include "transparency/abuffer/report.glsl"

// Composites the pixels of one class: as many nodes as fit into registers.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
#include "transparency/abuffer/filled.glsl"

void main() {
    Pixel pixel;
    if (!short_pixel(work_index(), pixel)) {
        return;
    }
    load_slots(pixel);
    sort_slots();
    GatheredSamples front = nothing_gathered();
    bool clamped = false;
    [[unroll]] for (uint i = 0u; i < SLOTS; i++) {
        bool there = i < pixel.count;
        Layer layer = node_layer(slot_key[i], slot_payload[i]);
        layer.rgb = mix(vec3(0.0), layer.rgb, bvec3(there));
        layer.through = mix(vec3(1.0), layer.through, bvec3(there));
        put_behind(front, layer, node_samples(uint(slot_key[i])));
        clamped = mix(clamped, true, all(bvec2(there, is_clamped(slot_payload[i]))));
    }
    if (clamped) {
        atomicAdd(report.clamped_pixels, 1u);
    }
    ivec2 at = pixel_at(pixel);
    check_filled(pixel, at);
    imageStore(color, at, over_opaque(front, imageLoad(color, at)));
}
