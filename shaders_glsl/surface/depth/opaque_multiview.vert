#version 460
#extension GL_EXT_multiview : require
#define MULTIVIEW
#include "surface/depth/opaque.glsl"
