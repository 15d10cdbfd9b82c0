#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_cover.glsl"

void main() {
    cover_triangle(instances[gl_InstanceIndex], uint(gl_VertexIndex));
}
