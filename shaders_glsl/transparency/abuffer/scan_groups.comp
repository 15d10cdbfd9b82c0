#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/scan.glsl"

// Sums before each chunk within its group, and what each group holds.

layout(local_size_x = 8) in;

layout(set = 0, binding = 1, scalar) buffer Chunks {
    Sums chunks[];
};
layout(set = 0, binding = 2, scalar) writeonly buffer Groups {
    Sums groups[];
};

void main() {
    uint group = gl_GlobalInvocationID.x;
    uint first = group * GROUP;
    if (first >= chunks.length()) {
        return;
    }
    uint end = min(first + GROUP, chunks.length());
    Sums before = NOTHING;
    for (uint chunk = first; chunk < end; ++chunk) {
        Sums own = chunks[chunk];
        chunks[chunk] = before;
        before = add(before, own);
    }
    groups[group] = before;
}
