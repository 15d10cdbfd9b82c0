#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_ballot : require
#define BY_SUBGROUP
#include "transparency/fragment.glsl"
#include "transparency/abuffer/list_append.glsl"

void main() {
    append(forward_layer(), fragment_key());
}
