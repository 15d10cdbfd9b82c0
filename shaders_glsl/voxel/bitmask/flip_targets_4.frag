#version 460
#define TARGETS 4
#include "voxel/bitmask/flip_targets.glsl"
