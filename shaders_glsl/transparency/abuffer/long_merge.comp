#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"

// Merges runs two to one. An invocation puts out RUN nodes, and finds where they begin in both runs by bisection
// (Odeh, Green, Mwassi, Shmueli and Birk 2012, "Merge path").

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) readonly uniform uimage2D from;
layout(set = 0, binding = 8, rgba32ui) writeonly uniform uimage2D to;

layout(push_constant, scalar) uniform MergePush {
    uint run; // nodes of a run
} push;

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel)) {
        return;
    }
    uint skip = gl_WorkGroupID.z * RUN;
    if (skip >= pixel.count || pixel.count <= push.run) {
        return;
    }
    // 1. The two runs
    uint pair = skip - skip % (2u * push.run);
    uint a_first = pixel.place + pair;
    uint a_end = pixel.place + min(pair + push.run, pixel.count);
    uint b_first = a_end;
    uint b_end = pixel.place + min(pair + 2u * push.run, pixel.count);

    // 2. How many of the first `before` nodes are of a
    uint before = skip - pair;
    uint low = before - min(before, b_end - b_first);
    uint high = min(before, a_end - a_first);
    while (low < high) {
        uint middle = (low + high) / 2u;
        uvec4 a_node = imageLoad(from, node_texel(a_first + middle));
        uvec4 b_node = imageLoad(from, node_texel(b_first + before - middle - 1u));
        if (in_front(a_node, b_node)) {
            low = middle + 1u;
        } else {
            high = middle;
        }
    }

    // 3. Merge
    uint a = a_first + low;
    uint b = b_first + before - low;
    uvec4 a_node = imageLoad(from, node_texel(a));
    uvec4 b_node = imageLoad(from, node_texel(b));
    uint end = pixel.place + min(skip + RUN, pixel.count);
    for (uint place = pixel.place + skip; place < end; ++place) {
        bool take_a = b == b_end || (a < a_end && in_front(a_node, b_node));
        imageStore(to, node_texel(place), take_a ? a_node : b_node);
        uint next = take_a ? ++a : ++b;
        uvec4 node = imageLoad(from, node_texel(next));
        a_node = take_a ? node : a_node;
        b_node = take_a ? b_node : node;
    }
}
