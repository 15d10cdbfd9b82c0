#version 460
#include "surface/gbuffer/gbuffer.glsl"
