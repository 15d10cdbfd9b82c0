#version 460
#include "common/surface_voxels_small.glsl"
#include "common/surface_bits.glsl"
