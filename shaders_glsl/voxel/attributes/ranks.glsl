// Counts of set bits before each word of a grid, chunk by chunk.

layout(local_size_x = 64) in;

const uint CHUNK = 1024u; // words

layout(push_constant, scalar) uniform RanksPush {
    uint words;
};
layout(set = 0, binding = 2, scalar) readonly buffer Bits {
    uint bits[];
};

// Dispatches may have rows, as one with an invocation a brick has.
uint chunk_of_invocation() {
    return gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
}
