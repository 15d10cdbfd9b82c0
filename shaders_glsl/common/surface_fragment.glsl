// Inputs of every fragment shader behind common/surface_vertex.glsl.
#include "common/instances.glsl"
#include "common/surface.glsl"

layout(location = 0) in vec3 vertex_normal;
layout(location = 1) in vec4 vertex_tangent;
layout(location = 2) in vec4 vertex_uv;
layout(location = 3) in vec4 vertex_color;
layout(location = 4) in vec3 vertex_position;
layout(location = 5) flat in uint vertex_instance;

Surface fragment_surface(Instance instance) {
    return material_surface(
        materials[instance.material], vertex_uv.xy, vertex_uv.zw, vertex_color,
        vertex_normal, vertex_tangent, instance.handedness, gl_FrontFacing
    );
}
