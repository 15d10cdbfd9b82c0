#version 460
#include "voxel/texels.glsl"
