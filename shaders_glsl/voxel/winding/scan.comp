#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/winding/band.glsl"

// Sums the crossings of each column: a voxel's winding number is what has been counted up to it. Where a bit says that
// something was counted, the count is taken and left 0 for the next band; then the voxels' bits take its place.

layout(local_size_x = 64) in;

layout(constant_id = 0) const bool EVEN_ODD = false;

layout(set = 0, binding = 2, scalar) buffer Counts {
    int counts[];
};
layout(set = 0, binding = 3, scalar) buffer Bits {
    uint bits[];
};

bool is_inside(int winding) {
    return EVEN_ODD ? (winding & 1) != 0 : winding != 0;
}

void main() {
    if (gl_GlobalInvocationID.x >= columns.x * rows) {
        return;
    }
    uvec2 column = uvec2(gl_GlobalInvocationID.x % columns.x, first_row + gl_GlobalInvocationID.x / columns.x);
    int winding = 0;
    for (uint word = 0u; word < words_in_column(); ++word) {
        uint index = word_index(column, word);
        uint counted = bits[index];
        uint mask = is_inside(winding) ? 0xffffffffu : 0u;
        while (counted != 0u) {
            int bit = findLSB(counted);
            counted &= counted - 1u;
            uint place = first_count(column, word) + uint(bit);
            winding += counts[place];
            counts[place] = 0;
            uint behind = 0xffffffffu << bit;
            mask = is_inside(winding) ? mask | behind : mask & ~behind;
        }
        bits[index] = mask & ~bits_from(int(columns.z), word);
    }
}
