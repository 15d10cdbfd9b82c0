#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/bitmask/marked.glsl"

// Flips the bit of the first voxel behind the surface; a prefix XOR flips those beyond it. Of surfaces: sets a bit.

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    int voxel = marked_voxel();
    if (voxel < 0 || voxel >= int(columns.z)) {
        return;
    }
    uint index = word_index(uvec2(gl_FragCoord.xy), uint(voxel) / 32u);
    uint bit = 1u << (uint(voxel) % 32u);
    if (SURFACE) {
        atomicOr(bits[index], bit);
    } else {
        atomicXor(bits[index], bit);
    }
}
