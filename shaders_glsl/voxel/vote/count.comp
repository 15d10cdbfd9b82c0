#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/vote/leak.glsl"

// Counts the columns that leak, a row of them an invocation.

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform LeaksPush {
    uint width; // columns in a row
    uint rows;
    uint axis; // 0: x, 1: y, 2: z
};
layout(set = 0, binding = 2, scalar) readonly buffer Crossings {
    int crossings[];
};
layout(set = 0, binding = 3, scalar) buffer Leaks {
    uint leaks[3];
};

void main() {
    uint row = gl_GlobalInvocationID.x;
    if (row >= rows) {
        return;
    }
    uint count = 0u;
    for (uint column = 0u; column < width; ++column) {
        count += uint(is_leak(crossings[row * width + column]));
    }
    if (count > 0u) {
        atomicAdd(leaks[axis], count);
    }
}
