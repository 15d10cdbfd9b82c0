#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"

// Merges sorted blocks of 16 nodes into runs of RUN nodes, an invocation a run.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) uniform uimage2D even;
layout(set = 0, binding = 8, rgba32ui) uniform uimage2D odd;

// Merges runs of `length` nodes of [first, end) two to one.
#define MERGE(from, to, length) { \
    uint a = first; \
    uint b = first; \
    uint a_end = first; \
    uint b_end = first; \
    uvec4 a_node = uvec4(0u); \
    uvec4 b_node = uvec4(0u); \
    for (uint place = first; place < end; ++place) { \
        if (a == a_end && b == b_end) { \
            a = place; \
            a_end = min(a + length, end); \
            b = a_end; \
            b_end = min(b + length, end); \
            a_node = imageLoad(from, node_texel(a)); \
            b_node = imageLoad(from, node_texel(b)); \
        } \
        bool take_a = b == b_end || (a < a_end && in_front(a_node, b_node)); \
        imageStore(to, node_texel(place), take_a ? a_node : b_node); \
        uint next = take_a ? ++a : ++b; \
        uvec4 node = imageLoad(from, node_texel(next)); \
        a_node = take_a ? node : a_node; \
        b_node = take_a ? b_node : node; \
    } \
}

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    uint skip = gl_WorkGroupID.z * RUN;
    if (skip >= pixel.count || sorted_in_place(pixel.count)) {
        return;
    }
    uint first = pixel.place + skip;
    uint end = pixel.place + min(skip + RUN, pixel.count);
    uint merges = min(merges_of(pixel.count), merges_of(RUN));
    for (uint done = 0u; done < merges; done += 2u) {
        uint length = SHORT << done;
        MERGE(even, odd, length)
        if (done + 1u < merges) {
            MERGE(odd, even, 2u * length)
        }
    }
}
