#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_columns.glsl"

void main() {
    look_along_columns();
}
