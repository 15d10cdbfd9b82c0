#version 460
#include "depth/opaque.glsl"
