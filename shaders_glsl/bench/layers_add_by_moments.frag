#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/moments/add_colors.glsl"

// One colour, so that shading hides nothing.

layout(location = 0) flat in uint layer;

void main() {
    add_seen(vec4(0.1, 0.2, 0.3, 0.4));
}
