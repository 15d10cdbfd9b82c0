#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/triangle_voxels.glsl"
#include "voxel/atlas/layout.glsl"

// Lays a triangle out in the chart of the axis that it faces most: seen along that axis, in voxels.

layout(location = 0) out vec3 surface; // column coordinates

void main() {
    Instance instance = instances[gl_InstanceIndex];
    uint place = uint(gl_VertexIndex);
    uint corner = (place - instance.first_index) % 3u;
    vec3 corners[3] = corners_at(instance, place - corner);
    uvec3 axes = facing(triangle_of(corners).normal);
    vec2 chart[3];
    for (uint i = 0u; i < 3u; ++i) {
        chart[i] = vec2(corners[i][axes.x], corners[i][axes.y]);
    }
    surface = corners[corner];
    gl_Position = place_in_atlas(chart, corner);
}
