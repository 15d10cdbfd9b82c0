#version 460
#extension GL_EXT_scalar_block_layout : require
#define MULTISAMPLED
#include "transparency/fragment.glsl"
#include "transparency/abuffer/list_append.glsl"

void main() {
    append(forward_layer(), fragment_key());
}
