#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_row.glsl"

// Sets the voxels of a row that the triangle touches.

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    Row row = fragment_row();
    for (int k = row.part.x; k <= row.part.y; ++k) {
        ivec3 voxel = row.voxel;
        voxel[row.axis] = k;
        if (makes_up(row.triangle, voxel)) {
            uint word = word_index(uvec2(voxel.xy), uint(voxel.z) / 32u);
            atomicOr(bits[word], 1u << (uint(voxel.z) % 32u));
        }
    }
}
