#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "common/voxel_bits.glsl"

// From bits to texels, 1 where a voxel is set: of a volume, or with TILED of slices along z, a tile each. A word of 32 voxels
// of a column an invocation.

layout(local_size_x = 8, local_size_y = 8) in;

#ifdef TILED
layout(push_constant, scalar) uniform TilesPush {
    uint across; // tiles side by side
};
layout(set = 0, binding = 3, r8) writeonly uniform image2D texels;
#else
layout(set = 0, binding = 3, r8) writeonly uniform image3D texels;
#endif

// From column coordinates to the grid's own.
uvec3 in_grid(uvec3 voxel) {
    return column_axis == 0u ? voxel.zxy : column_axis == 1u ? voxel.yzx : voxel;
}

void put(uvec3 voxel, float value) {
    uvec3 at = in_grid(voxel);
#ifdef TILED
    uvec2 tile = uvec2(at.z % across, at.z / across);
    imageStore(texels, ivec2(tile * in_grid(columns).xy + at.xy), vec4(value));
#else
    imageStore(texels, ivec3(at), vec4(value));
#endif
}

void main() {
    uvec3 first = uvec3(gl_GlobalInvocationID.xy, 32u * gl_GlobalInvocationID.z);
    if (any(greaterThanEqual(first, columns))) {
        return;
    }
    uint end = min(first.z + 32u, columns.z);
    for (uvec3 voxel = first; voxel.z < end; ++voxel.z) {
        put(voxel, is_set(voxel) ? 1.0 : 0.0);
    }
}
