#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/views.glsl"
#include "transparency/forward.glsl"
#include "transparency/stochastic/add_colors.glsl"

void main() {
    add_visible(forward_color());
}
