#version 460
#extension GL_EXT_scalar_block_layout : require
#define TRIANGLE_NUMBERS
#include "common/surface_vertex.glsl"
