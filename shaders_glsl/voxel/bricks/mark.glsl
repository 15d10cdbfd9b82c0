// Sets the voxels of a row that the triangle makes up, in bricks of 8³.
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_row.glsl"

layout(set = 0, binding = 2, scalar) readonly buffer Bits {
    uint bits[]; // of the grid of bricks, columns along z
};
layout(set = 0, binding = 7, scalar) readonly buffer Firsts {
    uint firsts[]; // bricks before each word
};
layout(set = 0, binding = 8, scalar) buffer Bricks {
    uint bricks[]; // 16 words each
};

void main() {
    Row row = fragment_row();
    uvec3 grid = (columns + 7u) / 8u;
    for (int k = row.part.x; k <= row.part.y; ++k) {
        ivec3 voxel = row.voxel;
        voxel[row.axis] = k;
        if (makes_up(row.triangle, voxel)) {
            uvec3 brick = uvec3(voxel) / 8u;
            uvec3 inner = uvec3(voxel) % 8u;
            uint word = (brick.z / 32u * grid.y + brick.y) * grid.x + brick.x;
            uint below = bits[word] & ((1u << (brick.z % 32u)) - 1u);
            uint place = 16u * (firsts[word] + bitCount(below)) + 2u * inner.z + inner.y / 4u;
            atomicOr(bricks[place], 1u << (inner.y % 4u * 8u + inner.x));
        }
    }
}
