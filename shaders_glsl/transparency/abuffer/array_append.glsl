// Appends fragments to their pixels' arrays. A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"

layout(early_fragment_tests) in;

#include "transparency/abuffer/nodes_write.glsl"
// By pixel, where its next node goes.
layout(set = 0, binding = 23, scalar) buffer Cursors {
    uint cursors[];
};

void append(Layer layer, uint key) {
    uint slot = atomicAdd(cursors[pixel_index(uvec2(gl_FragCoord.xy))], 1u);
    if (slot < abuffer.capacity) {
        store_node(slot, false, key, layer, NO_NODE);
    }
}
