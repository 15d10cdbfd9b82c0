#version 460
#extension GL_EXT_scalar_block_layout : require

// Counts the voxels that are set among the first bits and not among the second.

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform HolesPush {
    uint count; // words
    uint row; // words in a row of invocations
};
layout(set = 0, binding = 0, scalar) readonly buffer Wanted {
    uint wanted[];
};
layout(set = 0, binding = 1, scalar) readonly buffer Found {
    uint found[];
};
layout(set = 0, binding = 2, scalar) buffer Holes {
    uint holes;
};

void main() {
    uint index = gl_GlobalInvocationID.y * row + gl_GlobalInvocationID.x;
    if (index < count) {
        int missing = bitCount(wanted[index] & ~found[index]);
        if (missing > 0) {
            atomicAdd(holes, uint(missing));
        }
    }
}
