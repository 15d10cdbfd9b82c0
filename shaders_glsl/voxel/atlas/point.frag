#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"

// A texel's surface is a point: it sets the voxel that holds it.

layout(location = 0) in vec3 surface; // column coordinates

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    if (all(greaterThanEqual(surface, vec3(0.0))) && all(lessThan(surface, vec3(columns)))) {
        uvec3 voxel = uvec3(surface);
        atomicOr(bits[word_index(voxel.xy, voxel.z / 32u)], 1u << (voxel.z % 32u));
    }
}
