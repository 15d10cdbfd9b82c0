#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/stencil/slice.glsl"

// Only what lies before the slice, or in it, is counted.

layout(location = 0) in float depth;

void main() {
    if (first_voxel_behind(depth) > int(slice)) {
        discard;
    }
}
