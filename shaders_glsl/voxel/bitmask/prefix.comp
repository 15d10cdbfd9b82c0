#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"

// Prefix XOR of each column: a voxel is inside where an odd number of surfaces lies before it.

layout(local_size_x = 64) in;

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void main() {
    uint column = gl_GlobalInvocationID.x;
    if (column >= columns.x * columns.y) {
        return;
    }
    uint inside = 0u; // all ones, or none
    uint word = 0u;
    do {
        uint index = word * columns.x * columns.y + column;
        uint flips = bits[index];
        flips ^= flips << 1;
        flips ^= flips << 2;
        flips ^= flips << 4;
        flips ^= flips << 8;
        flips ^= flips << 16;
        flips ^= inside;
        bits[index] = flips & ~bits_from(int(columns.z), word);
        inside = 0u - (flips >> 31);
    } while (++word < words_in_column());
}
