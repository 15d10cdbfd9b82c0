#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/triangle_voxels.glsl"
#include "common/pulled_vertices.glsl"
#include "voxel/atlas/layout.glsl"

// Lays a triangle out by its second texture coordinates.

layout(location = 0) out vec3 surface; // column coordinates

void main() {
    Instance instance = instances[gl_InstanceIndex];
    uint place = uint(gl_VertexIndex);
    uint corner = (place - instance.first_index) % 3u;
    vec2 chart[3];
    for (uint i = 0u; i < 3u; ++i) {
        chart[i] = alpha_vertices[uint(int(indices[place - corner + i]) + instance.vertex_offset)].uv1;
    }
    surface = corner_at(instance, place);
    gl_Position = place_in_atlas(chart, corner);
}
