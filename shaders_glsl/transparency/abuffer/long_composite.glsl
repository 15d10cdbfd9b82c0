#include "transparency/abuffer/long.glsl"
#include "transparency/abuffer/nodes_read.glsl"
#include "transparency/abuffer/gather_samples.glsl"
#include "transparency/abuffer/report.glsl"

// Composites sorted nodes, nearest first, until nothing behind can be seen.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
#include "transparency/abuffer/filled.glsl"
layout(set = 0, binding = 7, rgba32ui) readonly uniform uimage2D even;
layout(set = 0, binding = 8, rgba32ui) readonly uniform uimage2D odd;

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    bool in_odd = (merges_of(pixel.count) & 1u) == 1u;
    GatheredSamples front = nothing_gathered();
    bool clamped = false;
    // Eight nodes a turn: lavapipe 22 ends loops after 65,535.
    for (uint done = 0u; done < pixel.count && !is_opaque(front); done += 8u) {
        for (uint i = 0u; i < 8u; i++) {
            bool there = done + i < pixel.count;
            ivec2 at = node_texel(pixel.place + min(done + i, pixel.count - 1u));
            uvec4 node = in_odd ? imageLoad(odd, at) : imageLoad(even, at);
            Layer layer = node_layer(signed_key(node.y), node.zw);
            layer.rgb = there ? layer.rgb : vec3(0.0);
            layer.through = there ? layer.through : vec3(1.0);
            put_behind(front, layer, node_samples(node.y));
            clamped = clamped || is_clamped(node.zw);
        }
    }
    if (clamped) {
        atomicAdd(report.clamped_pixels, 1u);
    }
    ivec2 at = pixel_at(pixel);
    check_filled(pixel, at);
    imageStore(color, at, over_opaque(front, imageLoad(color, at)));
}
