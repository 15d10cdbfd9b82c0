#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/alpha.glsl"
#include "transparency/moments/add_moments.glsl"

void main() {
    add_moments(forward_alpha());
}
