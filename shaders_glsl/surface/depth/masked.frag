#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/materials.glsl"

layout(location = 0) in vec4 uv;
layout(location = 1) in float vertex_alpha;

void main() {
    float alpha = material_base_color(uv.xy, uv.zw, vec4(1.0, 1.0, 1.0, vertex_alpha)).a;
    if (alpha < material.alpha_cutoff) {
        discard;
    }
}
