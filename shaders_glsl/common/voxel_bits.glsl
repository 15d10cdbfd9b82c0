// Bits of voxels: of a whole grid, or in bricks of 8³ where some are set (IN_BRICKS; columns along z). Whole grids have the
// bindings of bricks too, for whatever buffer.

layout(constant_id = 7) const bool IN_BRICKS = false;

layout(set = 0, binding = 2, scalar) readonly buffer Bits {
    uint bits[]; // a word of 32 voxels of a column; or 16 words a brick
};
layout(set = 0, binding = 13, scalar) readonly buffer Coarse {
    uint coarse[]; // the grid of bricks, a bit a brick that is there
};
layout(set = 0, binding = 14, scalar) readonly buffer BrickFirsts {
    uint brick_firsts[]; // bricks before each word of those
};

const uint NOWHERE = 0xffffffffu;

// First word of a brick; NOWHERE where it is not there.
uint brick_at(uvec3 brick) {
    uvec2 size = (columns.xy + 7u) / 8u;
    uint word = (brick.z / 32u * size.y + brick.y) * size.x + brick.x;
    uint bit = 1u << (brick.z % 32u);
    return (coarse[word] & bit) == 0u ? NOWHERE : 16u * (brick_firsts[word] + bitCount(coarse[word] & (bit - 1u)));
}

// The word with a voxel's bit, and which bit it is. NOWHERE where there is none.
uvec2 place_of(uvec3 voxel) {
    if (!IN_BRICKS) {
        return uvec2(word_index(voxel.xy, voxel.z / 32u), voxel.z % 32u);
    }
    uint first = brick_at(voxel / 8u);
    uvec3 inner = voxel % 8u;
    return uvec2(first == NOWHERE ? NOWHERE : first + 2u * inner.z + inner.y / 4u, inner.y % 4u * 8u + inner.x);
}

bool is_set(uvec3 voxel) {
    uvec2 place = place_of(voxel);
    return place.x != NOWHERE && (bits[place.x] >> place.y & 1u) != 0u;
}

// Whether any of the block of 2^level voxels an axis is set that a voxel is in; level is 2 at most. Of bricks.
bool is_any_set(uvec3 voxel, uint level) {
    uint first = brick_at(voxel / 8u);
    if (first == NOWHERE) {
        return false;
    }
    uvec3 corner = voxel % 8u >> level << level;
    uint side = 1u << level;
    // A row of the block, and its other rows, which lie in the same word.
    uint mask = ((1u << side) - 1u) * (level == 0u ? 1u : level == 1u ? 0x101u : 0x1010101u);
    uint found = 0u;
    for (uint z = corner.z; z < corner.z + side; ++z) {
        found |= bits[first + 2u * z + corner.y / 4u];
    }
    return (found & mask << (corner.y % 4u * 8u + corner.x)) != 0u;
}
