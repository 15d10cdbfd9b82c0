#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/alpha.glsl"
#include "transparency/key.glsl"
#include "transparency/stochastic/sample_depths.glsl"

void main() {
    sample_depth(forward_alpha(), fragment_key());
}
