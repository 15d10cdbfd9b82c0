#version 460
#define TILED
#include "voxel/stencil/gather.glsl"
