#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/fragment.glsl"
#include "transparency/dual_depth_peeling/peel.glsl"

void main() {
    peel(forward_layer(), fragment_key());
}
