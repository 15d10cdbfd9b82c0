// Appends fragments to their pixels' arrays. A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/node.glsl"

layout(early_fragment_tests) in;

layout(set = 0, binding = 22, rgba32ui) writeonly uniform uimage2D nodes;
// By pixel, where its next node goes.
layout(set = 0, binding = 23, scalar) buffer Cursors {
    uint cursors[];
};

void append(vec4 color, uint key) {
    uint slot = atomicAdd(cursors[pixel_index(uvec2(gl_FragCoord.xy))], 1u);
    if (slot < abuffer.capacity) {
        const uint TEXELS = NODE_FORMAT == NODE_FLOAT ? 2u : 1u;
        imageStore(nodes, node_texel(slot * TEXELS), pack_node(gl_FragCoord.z, key, color, NO_NODE));
        if (TEXELS > 1u) {
            imageStore(nodes, node_texel(slot * TEXELS + 1u), pack_node_rest(color, NO_NODE));
        }
    }
}
