// How many pairs each draw has.
#include "voxel/attributes/pairs.glsl"

layout(set = 0, binding = 10, scalar) buffer PairCounts {
    uint pair_counts[];
};

void take(uvec2 column, uint word, uint found) {
    uint count = uint(bitCount(set_among(column, word, found)));
    if (count != 0u) {
        atomicAdd(pair_counts[draw_of_instance[taken_instance]], count);
    }
}
