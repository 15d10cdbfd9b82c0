#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/vote/leak.glsl"

// Which columns along x or y do not leak: a bit for each place along z.

layout(local_size_x = 64) in;

layout(push_constant, scalar) uniform SoundPush {
    uvec2 size; // columns across, and along z
    uvec2 from; // from one column to the next, across and along z
};
layout(set = 0, binding = 0, scalar) readonly buffer Crossings {
    int crossings[];
};
layout(set = 0, binding = 1, scalar) writeonly buffer Sound {
    uint sound[];
};

void main() {
    uint across = gl_GlobalInvocationID.x;
    uint word = gl_GlobalInvocationID.y;
    if (across >= size.x) {
        return;
    }
    uint bits = 0u;
    uint end = min(32u, size.y - 32u * word);
    for (uint bit = 0u; bit < end; ++bit) {
        int crossed = crossings[across * from.x + (32u * word + bit) * from.y];
        bits |= uint(!is_leak(crossed)) << bit;
    }
    sound[word * size.x + across] = bits;
}
