#version 460
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/average.glsl"
#include "transparency/composite.glsl"

// Composites the kept layers nearest first, behind them the average of all others, and behind that what is opaque.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 3) const uint KEPT = 4u;

layout(set = 0, binding = 0) uniform texture2D sums;
layout(set = 0, binding = 1) uniform texture2D weights;
layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
layout(set = 0, binding = 22, r32ui) readonly uniform uimage2DArray kept_depths;
layout(set = 0, binding = 24, rgba32f) readonly uniform image2DArray kept_colors;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color))) || imageLoad(kept_depths, ivec3(pixel, 0)).r == 0u) {
        return;
    }
    Gathered front = NOTHING_GATHERED;
    for (uint place = 0u; place < KEPT; ++place) {
        bool there = imageLoad(kept_depths, ivec3(pixel, place)).r > 0u;
        Layer layer = plain_layer(there ? imageLoad(kept_colors, ivec3(pixel, place)) : vec4(0.0));
        if (TINTED && there) {
            layer.through = imageLoad(kept_colors, ivec3(pixel, KEPT + place)).rgb;
        }
        put_behind(front, layer);
    }
    vec4 sum = texelFetch(sums, pixel, 0);
    float weight = texelFetch(weights, pixel, 0).r;
    if (weight > 0.0) {
        put_behind(front, plain_layer(average_layer(sum.rgb, weight, sum.a)));
    }
    imageStore(color, pixel, over_opaque(front, imageLoad(color, pixel)));
}
