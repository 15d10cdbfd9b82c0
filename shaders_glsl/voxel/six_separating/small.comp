#version 460
#define SIX_SEPARATING
#include "common/surface_voxels_small.glsl"
#include "common/surface_bits.glsl"
