#version 460
#define TARGETS 8
#include "voxel/bitmask/flip_targets.glsl"
