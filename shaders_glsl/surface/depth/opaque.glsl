#extension GL_EXT_scalar_block_layout : require
#include "common/view_index.glsl"
#include "common/views.glsl"
#include "common/instance_transform.glsl"

layout(location = 0) in vec3 position;

// The G-buffer pass tests for equality with this depth.
invariant gl_Position;

void main() {
    vec3 world = transform_point(world_from_object(), position);
    gl_Position = views[VIEW_INDEX].clip_from_world * vec4(world, 1.0);
#ifdef LAYERED
    gl_Layer = int(VIEW_INDEX);
#endif
}
