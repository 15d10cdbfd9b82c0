#version 460
#extension GL_EXT_scalar_block_layout : require

// Set bits before each chunk, by one invocation: a grid has 32768 chunks at most.

layout(local_size_x = 1) in;

layout(push_constant, scalar) uniform TotalPush {
    uint chunk_count;
};
layout(set = 0, binding = 13, scalar) buffer Chunks {
    uint chunks[];
};
#define TOTAL_ACCESS writeonly
#include "voxel/attributes/total.glsl"

const uint ROW = 1024u; // workgroups

void main() {
    uint sum = 0u;
    for (uint chunk = 0u; chunk < chunk_count; ++chunk) {
        uint own = chunks[chunk];
        chunks[chunk] = sum;
        sum += own;
    }
    total = sum;
    uint groups = (sum + 63u) / 64u;
    group_count[0] = min(groups, ROW);
    group_count[1] = (groups + ROW - 1u) / ROW;
    group_count[2] = 1u;
}
