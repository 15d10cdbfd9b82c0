#version 460
#define TARGETS 1
#include "voxel/bitmask/flip_targets.glsl"
