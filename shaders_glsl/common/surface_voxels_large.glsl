#extension GL_EXT_scalar_block_layout : require
#include "common/surface_voxels.glsl"

// A large triangle a row of workgroups: its rows of columns are dealt out over all their invocations.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, scalar) readonly buffer LargeGroups {
    uint group_count[3];
    uint large_count;
};
layout(set = 0, binding = 8, scalar) readonly buffer LargeTriangles {
    uvec2 large_triangles[]; // number, rows of columns
};

void main() {
    uint stride = gl_NumWorkGroups.y * gl_WorkGroupSize.x;
    uint begin = gl_WorkGroupID.y * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
    for (uint place = gl_WorkGroupID.x; place < large_count; place += gl_NumWorkGroups.x) {
        uvec2 large = large_triangles[place];
        if (begin >= large.y) {
            continue;
        }
        Triangle triangle = triangle_at(large.x);
        for (uint row = begin; row < large.y; row += stride) {
            for (int x = triangle.first.x; x <= triangle.last.x; ++x) {
                visit_column(triangle, ivec2(x, triangle.first.y + int(row)));
            }
        }
    }
}
