#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_ARB_shader_viewport_layer_array : require
#include "common/voxel_columns.glsl"
#include "voxel/stencil/slice.glsl"

// One slice a layer. Triangles that lie behind it by half a voxel at least, where rounding does not matter, are dropped as
// a whole; to cut the others at it would move their corners to the rasteriser's grid.

out float gl_CullDistance[1];

void main() {
    look_along_columns();
    gl_CullDistance[0] = float(slice) + 1.0 - out_depth;
    gl_Layer = int(layer);
}
