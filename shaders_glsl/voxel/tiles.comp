#version 460
#define TILED
#include "voxel/texels.glsl"
