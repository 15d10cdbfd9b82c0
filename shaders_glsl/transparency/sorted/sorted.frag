#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/views.glsl"
#include "transparency/forward.glsl"

layout(location = 0) out vec4 color; // premultiplied

void main() {
    color = forward_color();
}
