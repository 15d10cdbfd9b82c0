#version 460
#extension GL_EXT_scalar_block_layout : require
#define FROM_BITS
#include "voxel/reduce.glsl"
