#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/winding/band.glsl"

// Sums the crossings of each column: a voxel's winding number is what has been counted up to it.

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool EVEN_ODD = false;

layout(set = 0, binding = 2, scalar) readonly buffer Counts {
    int counts[];
};
layout(set = 0, binding = 3, scalar) writeonly buffer Bits {
    uint bits[];
};

void main() {
    if (gl_GlobalInvocationID.x >= columns.x * rows) {
        return;
    }
    uvec2 column = uvec2(gl_GlobalInvocationID.x % columns.x, first_row + gl_GlobalInvocationID.x / columns.x);
    int winding = 0;
    for (uint word = 0u; word < words_in_column(); ++word) {
        uint mask = 0u;
        uint end = min(32u, columns.z - 32u * word);
        for (uint bit = 0u; bit < end; ++bit) {
            winding += counts[count_index(32u * word + bit, column)];
            mask |= uint(EVEN_ODD ? (winding & 1) != 0 : winding != 0) << bit;
        }
        bits[word_index(column, word)] = mask;
    }
}
