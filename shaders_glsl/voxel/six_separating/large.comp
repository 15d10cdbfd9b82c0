#version 460
#define SIX_SEPARATING
#include "common/surface_voxels_large.glsl"
#include "common/surface_bits.glsl"
