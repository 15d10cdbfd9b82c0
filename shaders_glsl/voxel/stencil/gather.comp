#version 460
#include "voxel/stencil/gather.glsl"
