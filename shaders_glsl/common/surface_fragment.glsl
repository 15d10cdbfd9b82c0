// Inputs of every fragment shader behind common/surface_vertex.glsl.
#include "common/surface.glsl"

#ifdef MULTISAMPLED
// Pixels' centres may lie outside of the triangle: nothing is extrapolated.
#define SURFACE_IN centroid in
#else
#define SURFACE_IN in
#endif

layout(location = 0) SURFACE_IN vec3 vertex_normal;
layout(location = 1) SURFACE_IN vec4 vertex_tangent;
layout(location = 2) SURFACE_IN vec4 vertex_uv;
layout(location = 3) SURFACE_IN vec4 vertex_color;
layout(location = 4) SURFACE_IN vec3 vertex_position;
layout(location = 5) flat in uvec3 vertex_ids; // object, first primitive, material

Surface fragment_surface() {
    vec2 uv0 = vertex_uv.xy;
    vec2 uv1 = vertex_uv.zw;
    return material_surface(uv0, uv1, vertex_color, vertex_normal, vertex_tangent, gl_FrontFacing);
}
