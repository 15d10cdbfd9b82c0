#version 460
#extension GL_ARB_shader_viewport_layer_array : require
#define LAYERED
#include "surface/depth/masked.glsl"
