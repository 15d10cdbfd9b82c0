#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"

// Flips the bit of the first voxel behind the surface; a prefix XOR flips those beyond it.

layout(location = 0) in float depth;

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    int first = max(first_voxel_behind(depth), 0);
    if (first < int(columns.z)) {
        atomicXor(bits[word_index(uvec2(gl_FragCoord.xy), uint(first) / 32u)], 1u << (uint(first) % 32u));
    }
}
