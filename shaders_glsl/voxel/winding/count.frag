#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/winding/band.glsl"

// Counts a crossing at the first voxel behind it: one more where the surface faces the viewer, one less where it faces
// away. The voxel's bit tells the scan to look there.

layout(location = 0) in float depth;

layout(set = 0, binding = 2, scalar) buffer Counts {
    int counts[];
};
layout(set = 0, binding = 3, scalar) buffer Bits {
    uint bits[];
};

void main() {
    int first = max(first_voxel_behind(depth), 0);
    if (first < int(columns.z)) {
        uvec2 column = uvec2(gl_FragCoord.xy);
        uint word = uint(first) / 32u;
        uint bit = uint(first) % 32u;
        atomicAdd(counts[first_count(column, word) + bit], gl_FrontFacing ? 1 : -1);
        atomicOr(bits[word_index(column, word)], 1u << bit);
    }
}
