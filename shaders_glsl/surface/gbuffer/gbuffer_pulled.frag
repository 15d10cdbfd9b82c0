#version 460
#define PULL_VERTICES
#include "surface/gbuffer/gbuffer.glsl"
