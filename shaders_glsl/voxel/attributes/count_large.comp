#version 460
#include "common/surface_voxels_large.glsl"
#include "voxel/attributes/count_pairs.glsl"
