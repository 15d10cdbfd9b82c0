#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/scan.glsl"

// What each chunk of pixels holds.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 1, scalar) writeonly buffer Chunks {
    Sums chunks[];
};

void main() {
    uint chunk = gl_GlobalInvocationID.x;
    uint pixels = abuffer.size.x * abuffer.size.y;
    if (chunk >= chunks.length()) {
        return;
    }
    // A band may have fewer chunks than there is room for.
    uint first = chunk * CHUNK;
    uint end = min(first + CHUNK, pixels);
    Sums sums = NOTHING;
    ivec2 at = pixel_of(first);
    for (uint pixel = first; pixel < end; ++pixel) {
        uint count = uint(texelFetch(counts, at, 0).r) * abuffer.used;
        uint own = class_of(count);
        sums.nodes = add_nodes(sums.nodes, count);
        sums.longest = max(sums.longest, count);
        sums.pixels[0] += uint(own == 0u && count > 0u);
        sums.pixels[1] += uint(own == 1u);
        sums.pixels[2] += uint(own == 2u);
        sums.pixels[3] += uint(own == 3u);
        at = next_pixel(at);
    }
    chunks[chunk] = sums;
}
