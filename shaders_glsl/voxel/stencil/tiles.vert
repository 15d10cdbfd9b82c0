#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_columns.glsl"
#include "voxel/stencil/slice.glsl"

// One slice a tile of the attachment, which the scissor keeps it in. Triangles behind it are dropped as in slices.vert.

out float gl_CullDistance[1];

void main() {
    vec2 column = snapped_column();
    gl_Position = vec4(2.0 * (column + vec2(corner)) / vec2(area) - 1.0, 0.5, 1.0);
    gl_CullDistance[0] = float(slice) + 1.0 - out_depth;
}
