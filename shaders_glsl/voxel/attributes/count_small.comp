#version 460
#include "common/surface_voxels_small.glsl"
#include "voxel/attributes/count_pairs.glsl"
