#version 460
#define PAIR_ACCESS writeonly
#include "common/surface_voxels_small.glsl"
#include "voxel/attributes/list_pairs.glsl"
