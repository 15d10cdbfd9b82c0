// Lists the pairs of each draw.
#include "voxel/attributes/pairs.glsl"
#include "voxel/attributes/pair_lists.glsl"

layout(set = 0, binding = 10, scalar) buffer PairCounts {
    uint pair_counts[]; // listed so far
};
layout(set = 0, binding = 11, scalar) readonly buffer PairStarts {
    uint pair_starts[]; // of each draw
};
layout(set = 0, binding = 12, scalar) readonly buffer Firsts {
    uint firsts[]; // set voxels before each word
};

void take(uvec2 column, uint word, uint found) {
    uint set = set_among(column, word, found);
    if (set == 0u) {
        return;
    }
    uint draw = draw_of_instance[taken_instance];
    uint pair = pair_starts[draw] + atomicAdd(pair_counts[draw], uint(bitCount(set)));
    while (set != 0u) {
        uvec3 voxel = uvec3(column, 32u * word + uint(findLSB(set)));
        set &= set - 1u;
        uvec2 place = place_of(voxel);
        uint rank = firsts[place.x] + uint(bitCount(bits[place.x] & ((1u << place.y) - 1u)));
        pair_triangles[pair] = uvec2(taken_place, taken_instance);
        pair_voxels[pair] = pack_voxel(voxel, rank);
        ++pair;
    }
}
