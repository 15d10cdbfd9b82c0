#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/bitmask/marked.glsl"

// Flips the bits of all voxels behind the surface.

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    int first = marked_voxel();
    for (uint word = uint(first) / 32u; word < words_in_column(); ++word) {
        atomicXor(bits[word_index(uvec2(gl_FragCoord.xy), word)], bits_from(first, word) & ~bits_from(int(columns.z), word));
    }
}
