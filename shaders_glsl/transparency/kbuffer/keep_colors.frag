#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/fragment.glsl"
#include "transparency/kbuffer/keep_colors.glsl"

void main() {
    keep_color(forward_layer(), fragment_key());
}
