#version 460
#extension GL_EXT_scalar_block_layout : require
#define PULL_VERTICES
#define TRIANGLE_NUMBERS
#include "common/surface_vertex.glsl"
