#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/views.glsl"
#include "transparency/forward.glsl"
#include "transparency/weighted/weigh.glsl"

void main() {
    weigh(forward_color());
}
