// Appends fragments to their pixels' arrays. A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"

layout(early_fragment_tests) in;

#include "transparency/abuffer/nodes_write.glsl"

// By pixel, where its next node goes. Where fragments of a pixel run one after the other, it is read and written as an
// attachment; an atomic addition costs several times as much.
#ifdef IN_ORDER
layout(input_attachment_index = 0, set = 0, binding = 23) uniform usubpassInput cursor;
layout(location = 0) out uint next_cursor;

uint take_node() {
    uint node = subpassLoad(cursor).r;
    next_cursor = node + 1u;
    return node;
}
#else
layout(set = 0, binding = 23, r32ui) uniform uimage2D cursors;

uint take_node() {
    return imageAtomicAdd(cursors, ivec2(gl_FragCoord.xy), 1u);
}
#endif

void append(Layer layer, uint key) {
    Covered covered = fragment_covered();
#ifdef MULTISAMPLED
    // llvmpipe's scissor lets samples of the row before it pass.
    if (uint(gl_FragCoord.y) - abuffer.first_row >= abuffer.size.y) {
        return;
    }
#endif
    uint node = take_node();
    if (node < abuffer.capacity) {
        store_node(node, covered, key, layer, NO_NODE, false);
    }
}
