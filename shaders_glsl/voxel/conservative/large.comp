#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/conservative/touch.glsl"

// A large triangle a row of workgroups: its columns are dealt out over all their invocations.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, scalar) readonly buffer LargeGroups {
    uint group_count[3];
    uint large_count;
};
layout(set = 0, binding = 8, scalar) readonly buffer LargeTriangles {
    uint large_triangles[];
};

void main() {
    uint stride = gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    uint begin = gl_WorkGroupID.y * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    for (uint place = gl_WorkGroupID.x; place < large_count; place += gl_NumWorkGroups.x) {
        Triangle triangle = triangle_at(large_triangles[place]);
        ivec2 size = triangle.last.xy - triangle.first.xy + 1;
        uint end = uint(size.x * size.y);
        for (uint i = begin; i < end; i += stride) {
            mark_column(triangle, triangle.first.xy + ivec2(int(i) % size.x, int(i) / size.x));
        }
    }
}
