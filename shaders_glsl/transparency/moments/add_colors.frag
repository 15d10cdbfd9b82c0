#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/views.glsl"
#include "transparency/forward.glsl"
#include "transparency/moments/add_colors.glsl"

void main() {
    add_seen(forward_color());
}
