// Pairs of a triangle and a set voxel that it touches. Those of a draw lie one behind the other, in any order.

layout(set = 0, binding = 9, scalar) readonly buffer DrawOfInstance {
    uint draw_of_instance[];
};
#include "common/voxel_bits.glsl"

// Bits of a column that are set among those found.
uint set_among(uvec2 column, uint word, uint found) {
    if (!IN_BRICKS) {
        return found & bits[word_index(column, word)];
    }
    uint set = 0u;
    while (found != 0u) {
        uint bit = uint(findLSB(found));
        found &= found - 1u;
        set |= uint(is_set(uvec3(column, 32u * word + bit))) << bit;
    }
    return set;
}
