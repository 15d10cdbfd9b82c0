#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/kbuffer/keep_depths.glsl"

// One colour, so that shading hides nothing.

layout(location = 0) flat in uint layer;

void main() {
    keep_depth();
}
