// Counts of set bits before each word of a grid, chunk by chunk.

layout(local_size_x = 64) in;

const uint CHUNK = 1024u; // words

layout(push_constant, scalar) uniform RanksPush {
    uint words;
};
layout(set = 0, binding = 2, scalar) readonly buffer Bits {
    uint bits[];
};
