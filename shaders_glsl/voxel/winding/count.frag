#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/winding/band.glsl"

// Counts a crossing at the first voxel behind it: one more where the surface faces the viewer, one less where it faces away.

layout(location = 0) in float depth;

layout(set = 0, binding = 2, scalar) buffer Counts {
    int counts[];
};

void main() {
    int first = max(first_voxel_behind(depth), 0);
    if (first < int(columns.z)) {
        atomicAdd(counts[count_index(uint(first), uvec2(gl_FragCoord.xy))], gl_FrontFacing ? 1 : -1);
    }
}
