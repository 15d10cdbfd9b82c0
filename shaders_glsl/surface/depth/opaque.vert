#version 460
#include "surface/depth/opaque.glsl"
