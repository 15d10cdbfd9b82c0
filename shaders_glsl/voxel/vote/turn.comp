#version 460
#extension GL_EXT_scalar_block_layout : require

// Turns words of columns along x or y into words of columns along z. An invocation turns 32 words, of neighbours along z,
// as a matrix of bits (Warren, Hacker's Delight, 2nd edition 2012, section 7-3).

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform TurnPush {
    uvec3 size; // voxels along the columns, across them, along z
    uvec3 from; // words from one to the next: of a column, across, along z
    uvec3 to; // words from one voxel to the next: along the columns, across; from word to word along z
};
layout(set = 0, binding = 0, scalar) readonly buffer Columns {
    uint columns[];
};
layout(set = 0, binding = 1, scalar) writeonly buffer Turned {
    uint turned[];
};

// Swaps the two blocks off the diagonal in each square of twice `width`; `low` has the lower half of the bits of each.
void swap_blocks(inout uint rows[32], const uint width, const uint low) {
    for (uint i = 0u; i < 16u; ++i) {
        uint row = 2u * i - i % width;
        uint swapped = (rows[row] >> width ^ rows[row + width]) & low;
        rows[row] ^= swapped << width;
        rows[row + width] ^= swapped;
    }
}

void main() {
    uint across = gl_GlobalInvocationID.x;
    uint word = gl_GlobalInvocationID.y;
    uint z = 32u * gl_GlobalInvocationID.z;
    if (across >= size.y || 32u * word >= size.x || z >= size.z) {
        return;
    }
    uint rows[32];
    uint first = word * from.x + across * from.y;
    for (uint i = 0u; i < 32u; ++i) {
        rows[i] = z + i < size.z ? columns[first + (z + i) * from.z] : 0u;
    }
    swap_blocks(rows, 16u, 0x0000ffffu);
    swap_blocks(rows, 8u, 0x00ff00ffu);
    swap_blocks(rows, 4u, 0x0f0f0f0fu);
    swap_blocks(rows, 2u, 0x33333333u);
    swap_blocks(rows, 1u, 0x55555555u);
    for (uint i = 0u; i < 32u; ++i) {
        uint along = 32u * word + i;
        if (along < size.x) {
            turned[along * to.x + across * to.y + gl_GlobalInvocationID.z * to.z] = rows[i];
        }
    }
}
