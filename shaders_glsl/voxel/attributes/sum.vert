#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_cover.glsl"

layout(location = 3) flat out uvec4 out_vertices; // of the triangle; its instance

void main() {
    Instance instance = instances[gl_InstanceIndex];
    uint place = uint(gl_VertexIndex);
    cover_triangle(instance, place);
    place -= (place - instance.first_index) % 3u;
    ivec3 vertices = ivec3(indices[place], indices[place + 1u], indices[place + 2u]) + instance.vertex_offset;
    out_vertices = uvec4(vertices, gl_InstanceIndex);
}
