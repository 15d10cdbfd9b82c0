// Appends fragments to their pixels' linked lists (Yang et al. 2010, "Real-time concurrent linked list construction on
// the GPU"). A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"

layout(early_fragment_tests) in;

#include "transparency/abuffer/nodes_write.glsl"
// By pixel, the node appended last.
layout(set = 0, binding = 23, r32ui) uniform uimage2D heads;
// Fragments so far, stored or not.
layout(set = 0, binding = 24, scalar) buffer Counter {
    uint fragment_count;
};

void append(Layer layer, uint key) {
    uint node = atomicAdd(fragment_count, 1u);
    if (node < abuffer.capacity) {
        uint next = imageAtomicExchange(heads, ivec2(gl_FragCoord.xy), node);
        store_node(node, true, key, layer, next);
    }
}
