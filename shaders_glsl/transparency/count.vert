#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/view_index.glsl"
#include "common/views.glsl"
#include "common/instance_transform.glsl"

layout(location = 0) in vec3 position;

invariant gl_Position;

void main() {
    vec3 world = transform_point(world_from_object(), position);
    gl_Position = views[VIEW_INDEX].clip_from_world * vec4(world, 1.0);
}
