#version 460
#extension GL_EXT_scalar_block_layout : require
#define LISTS
#include "transparency/abuffer/scan_offsets.glsl"
