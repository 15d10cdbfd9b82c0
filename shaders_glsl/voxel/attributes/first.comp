#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/attributes/ranks.glsl"

// Set bits before each word.

layout(set = 0, binding = 13, scalar) readonly buffer Chunks {
    uint chunks[];
};
layout(set = 0, binding = 7, scalar) writeonly buffer Firsts {
    uint firsts[];
};

void main() {
    uint chunk = chunk_of_invocation();
    if (chunk * CHUNK >= words) {
        return;
    }
    uint end = min((chunk + 1u) * CHUNK, words);
    uint before = chunks[chunk];
    for (uint word = chunk * CHUNK; word < end; ++word) {
        firsts[word] = before;
        before += uint(bitCount(bits[word]));
    }
}
