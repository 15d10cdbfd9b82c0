#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require

// How many layers the deepest pixel has, and how many are deeper than can be peeled.

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 1, scalar) buffer MostLayers {
    uint most; // of a pixel
    uint too_deep; // fragments
} layers;

layout(push_constant, scalar) uniform MostLayersPush {
    uint allowed;
} push;

const uint CHUNK = 256u; // pixels an invocation

void main() {
    uvec2 size = uvec2(textureSize(counts, 0));
    uint first = gl_GlobalInvocationID.x * CHUNK;
    uint end = min(first + CHUNK, size.x * size.y);
    uint most = 0u;
    uint too_deep = 0u;
    for (uint pixel = first; pixel < end; ++pixel) {
        uint count = uint(texelFetch(counts, ivec2(pixel % size.x, pixel / size.x), 0).r);
        most = max(most, count);
        too_deep += max(count, push.allowed) - push.allowed;
    }
    if (most > 0u) {
        atomicMax(layers.most, most);
    }
    if (too_deep > 0u) {
        atomicAdd(layers.too_deep, too_deep);
    }
}
