#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/attributes/ranks.glsl"

// Set bits of each chunk.

layout(set = 0, binding = 13, scalar) writeonly buffer Chunks {
    uint chunks[];
};

void main() {
    uint chunk = chunk_of_invocation();
    if (chunk * CHUNK >= words) {
        return;
    }
    uint end = min((chunk + 1u) * CHUNK, words);
    uint count = 0u;
    for (uint word = chunk * CHUNK; word < end; ++word) {
        count += uint(bitCount(bits[word]));
    }
    chunks[chunk] = count;
}
