#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/view_index.glsl"
#include "common/views.glsl"
#include "common/surface_fragment.glsl"
#include "transparency/key.glsl"
#include "transparency/abuffer/array_append.glsl"
#include "transparency/passing.glsl"

// What a surface lets through of a light's light, as the light sees it.

void main() {
    vec3 to_light = direction_to_eye(VIEW_INDEX, vertex_position);
    append(tinted_layer(vec3(0.0), passing(fragment_surface(), to_light)), fragment_key());
}
