#version 460
#include "surface/depth/masked.glsl"
