#extension GL_EXT_scalar_block_layout : require
#include "common/view_index.glsl"
#include "common/views.glsl"
#include "common/instance_transform.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv0;
layout(location = 2) in vec2 uv1;
layout(location = 3) in vec4 color;

layout(location = 0) out vec4 out_uv;
layout(location = 1) out float out_alpha;

invariant gl_Position;

void main() {
    vec3 world = transform_point(world_from_object(), position);
    gl_Position = views[VIEW_INDEX].clip_from_world * vec4(world, 1.0);
#ifdef LAYERED
    gl_Layer = int(VIEW_INDEX);
#endif
    out_uv = vec4(uv0, uv1);
    out_alpha = color.a;
}
