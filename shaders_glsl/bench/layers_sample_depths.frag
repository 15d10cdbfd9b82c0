#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/stochastic/sample_depths.glsl"

// One colour, so that shading hides nothing.

layout(location = 0) flat in uint layer;

void main() {
    sample_depth(0.4, layer);
}
