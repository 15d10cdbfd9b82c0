// A coarser level of a bit pyramid: a voxel is set where any of 2×2×2 finer ones is. Levels lie as the bits of a grid do.

layout(local_size_x = 8, local_size_y = 8) in;

layout(push_constant, scalar) uniform ReducePush {
    uvec3 size; // voxels of the finer level, in column coordinates
    uint finer; // where it begins, in words
    uint coarser; // where the coarser one begins
};

#ifdef FROM_BITS
layout(set = 0, binding = 0, scalar) readonly buffer Bits {
    uint bits[];
};
#define FINER bits
layout(set = 0, binding = 1, scalar) writeonly buffer Pyramid {
    uint pyramid[];
};
#else
layout(set = 0, binding = 1, scalar) buffer Pyramid {
    uint pyramid[];
};
#define FINER pyramid
#endif

uint finer_word(uvec2 column, uint word) {
    if (any(greaterThanEqual(column, size.xy)) || 32u * word >= size.z) {
        return 0u;
    }
    return FINER[finer + (word * size.y + column.y) * size.x + column.x];
}

uint four_columns(uvec2 column, uint word) {
    return finer_word(column, word) | finer_word(column + uvec2(1, 0), word) | finer_word(column + uvec2(0, 1), word) |
        finer_word(column + uvec2(1, 1), word);
}

// Pairs of 32 bits, a bit each.
uint pairs(uint word) {
    word = (word | word >> 1) & 0x55555555u;
    word = (word | word >> 1) & 0x33333333u;
    word = (word | word >> 2) & 0x0f0f0f0fu;
    word = (word | word >> 4) & 0x00ff00ffu;
    return (word | word >> 8) & 0x0000ffffu;
}

void main() {
    uvec3 coarse = (size + 1u) / 2u;
    uvec2 column = gl_GlobalInvocationID.xy;
    uint word = gl_GlobalInvocationID.z;
    if (any(greaterThanEqual(column, coarse.xy)) || 32u * word >= coarse.z) {
        return;
    }
    pyramid[coarser + (word * coarse.y + column.y) * coarse.x + column.x] =
        pairs(four_columns(2u * column, 2u * word)) | pairs(four_columns(2u * column, 2u * word + 1u)) << 16;
}
