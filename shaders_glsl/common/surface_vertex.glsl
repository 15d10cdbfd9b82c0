// Vertex stage of everything that shades a surface.
#include "common/view_index.glsl"
#include "common/views.glsl"
#include "common/instances.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv0;
layout(location = 2) in vec2 uv1;
layout(location = 3) in vec4 color;
layout(location = 4) in vec3 normal;
layout(location = 5) in vec4 tangent;

layout(location = 0) out vec3 out_normal;
layout(location = 1) out vec4 out_tangent;
layout(location = 2) out vec4 out_uv;
layout(location = 3) out vec4 out_color;
layout(location = 4) out vec3 out_position;
layout(location = 5) flat out uvec3 out_ids; // object, first primitive, material

invariant gl_Position;

void main() {
    Instance instance = instances[gl_InstanceIndex];
    vec3 world = transform_point(instances[gl_InstanceIndex], position);
    gl_Position = views[VIEW_INDEX].clip_from_world * vec4(world, 1.0);
    out_position = world;
    out_normal = transform_normal(instance, normal);
    out_tangent = vec4(transform_direction(instance, tangent.xyz), tangent.w * instance.handedness);
    out_uv = vec4(uv0, uv1);
    out_color = color;
    out_ids = uvec3(instance.object, instance.first_primitive, instance.material);
}
