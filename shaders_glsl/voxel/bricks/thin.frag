#version 460
#define SIX_SEPARATING
#include "voxel/bricks/mark.glsl"
