// Vertex stage of everything that shades a surface.
#include "common/view_index.glsl"
#include "common/views.glsl"

#ifdef PULL_VERTICES
// Vertices fetched by hand, without an index buffer, so that the vertex shader knows its triangle: a fragment shader's
// gl_PrimitiveID asks for geometry shaders, which not every device has.
#include "common/instances.glsl"
#include "common/pulled_vertices.glsl"

layout(set = 0, binding = 17, scalar) readonly buffer Indices {
    uint indices[];
};
layout(set = 0, binding = 18, scalar) readonly buffer Positions {
    vec3 positions[];
};
layout(location = 6) flat out uint out_primitive;
#else
#include "common/instance_transform.glsl"

layout(location = 9) in vec3 normal_x_from_object; // rows
layout(location = 10) in vec3 normal_y_from_object;
layout(location = 11) in vec3 normal_z_from_object;
layout(location = 12) in float handedness;
layout(location = 13) in uvec4 numbers; // object, material, first primitive, first blended triangle

layout(location = 0) in vec3 position;
layout(location = 1) in vec2 uv0;
layout(location = 2) in vec2 uv1;
layout(location = 3) in vec4 color;
layout(location = 4) in vec3 normal;
layout(location = 5) in vec4 tangent;
#endif

layout(location = 0) out vec3 out_normal;
layout(location = 1) out vec4 out_tangent;
layout(location = 2) out vec4 out_uv;
layout(location = 3) out vec4 out_color;
layout(location = 4) out vec3 out_position;
layout(location = 5) flat out uvec3 out_ids; // object, first primitive, material
#ifdef TRIANGLE_NUMBERS
layout(location = 7) flat out uint out_first_triangle;
#endif

invariant gl_Position;

void main() {
#ifdef PULL_VERTICES
    Instance instance = instances[gl_InstanceIndex];
    uint vertex = indices[gl_VertexIndex] + instance.vertex_offset;
    vec3 position = positions[vertex];
    vec2 uv0 = alpha_vertices[vertex].uv0;
    vec2 uv1 = alpha_vertices[vertex].uv1;
    vec4 color = alpha_vertices[vertex].color;
    vec3 normal = shading_vertices[vertex].normal;
    vec4 tangent = shading_vertices[vertex].tangent;
    out_primitive = (uint(gl_VertexIndex) - instance.first_index) / 3u;
#else
    vec3 normal_from_object[] = vec3[](normal_x_from_object, normal_y_from_object, normal_z_from_object);
    Instance instance = Instance(
        world_from_object(), normal_from_object, handedness, numbers.x, numbers.y, numbers.z, numbers.w, 0u, 0
    );
#endif
    vec3 world = transform_point(instance.world_from_object, position);
    gl_Position = views[VIEW_INDEX].clip_from_world * vec4(world, 1.0);
    out_position = world;
    out_normal = transform_normal(instance, normal);
    out_tangent = vec4(transform_direction(instance, tangent.xyz), tangent.w * instance.handedness);
    out_uv = vec4(uv0, uv1);
    out_color = color;
    out_ids = uvec3(instance.object, instance.first_primitive, instance.material);
#ifdef TRIANGLE_NUMBERS
    out_first_triangle = instance.first_blended;
#endif
}
