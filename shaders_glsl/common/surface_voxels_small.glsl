#extension GL_EXT_scalar_block_layout : require
#include "common/surface_voxels.glsl"

// A triangle an invocation. Those with many voxels in their bounds are left to many invocations each.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, scalar) buffer LargeGroups {
    uint group_count[3]; // of the indirect dispatch
    uint large_count;
};
layout(set = 0, binding = 8, scalar) writeonly buffer LargeTriangles {
    uvec2 large_triangles[]; // number, rows of columns
};

const float MOST_VOXELS = 4096.0;
const uint SLICES = 4u; // workgroups a large triangle
const uint MOST_GROUPS = 65535u; // every device dispatches so many

void main() {
    uint number = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (number == 0u) {
        group_count[1] = SLICES;
        group_count[2] = 1u;
    }
    if (number >= touch.triangle_count) {
        return;
    }
    Triangle triangle = triangle_at(number);
    ivec3 size = triangle.last - triangle.first + 1;
    if (any(lessThanEqual(size, ivec3(0)))) {
        return;
    }
    if (float(size.x) * float(size.y) * float(size.z) > MOST_VOXELS) {
        uint place = atomicAdd(large_count, 1u);
        large_triangles[place] = uvec2(number, size.y);
        atomicMax(group_count[0], min(place + 1u, MOST_GROUPS));
        return;
    }
    int end = size.x * size.y;
    for (int i = 0; i < end; ++i) {
        visit_column(triangle, triangle.first.xy + ivec2(i % size.x, i / size.x));
    }
}
