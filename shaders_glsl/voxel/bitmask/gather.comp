#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/voxels.glsl"

// From attachments to words. `masks` holds 128 voxels of each column a layer, from the first of these words on.

layout(local_size_x = 8, local_size_y = 8) in;

layout(push_constant, scalar) uniform GatherPush {
    uint first_word;
    uint end_word;
};
layout(set = 0, binding = 2, scalar) writeonly buffer Bits {
    uint bits[];
};
layout(set = 0, binding = 3) uniform utexture2DArray masks;

void main() {
    uvec2 column = gl_GlobalInvocationID.xy;
    if (any(greaterThanEqual(column, columns.xy))) {
        return;
    }
    uint word = first_word;
    do {
        uvec4 words = texelFetch(masks, ivec3(column, (word - first_word) / 4u), 0);
        uint mask = words[word % 4u] & ~bits_from(int(columns.z), word);
        bits[word_index(column, word)] = mask;
    } while (++word < end_word);
}
