#version 460
#include "depth/masked.glsl"
