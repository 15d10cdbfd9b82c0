#version 460
#include "voxel/bricks/mark.glsl"
