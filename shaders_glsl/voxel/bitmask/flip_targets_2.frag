#version 460
#define TARGETS 2
#include "voxel/bitmask/flip_targets.glsl"
