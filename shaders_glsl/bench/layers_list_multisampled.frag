#version 460
#extension GL_EXT_scalar_block_layout : require
#define MULTISAMPLED
#include "transparency/abuffer/list_append.glsl"

// One colour, so that shading hides nothing.

layout(location = 0) flat in uint layer;

void main() {
    append(plain_layer(vec4(0.1, 0.2, 0.3, 0.4)), layer);
}
