#version 460
#include "common/surface_voxels_large.glsl"
#include "common/surface_bits.glsl"
