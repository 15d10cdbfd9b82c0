#version 460
#extension GL_EXT_scalar_block_layout : require
#define MULTISAMPLED
#include "transparency/abuffer/resolve.glsl"
