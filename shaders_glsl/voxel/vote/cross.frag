#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"

// Counts the surfaces of a whole column, beyond the grid too: those that face the viewer against those that face away.

layout(location = 0) in float depth;

layout(set = 0, binding = 2, scalar) buffer Crossings {
    int crossings[]; // by column
};

void main() {
    uvec2 column = uvec2(gl_FragCoord.xy);
    atomicAdd(crossings[column.y * columns.x + column.x], gl_FrontFacing ? 1 : -1);
}
