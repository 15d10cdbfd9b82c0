// Appends fragments to their pixels' linked lists (Yang et al. 2010, "Real-time concurrent linked list construction on
// the GPU"). A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/node.glsl"

layout(early_fragment_tests) in;

layout(set = 0, binding = 22, rgba32ui) writeonly uniform uimage2D nodes;
// By pixel, the node appended last.
layout(set = 0, binding = 23, r32ui) uniform uimage2D heads;
// Fragments so far, stored or not.
layout(set = 0, binding = 24, scalar) buffer Counter {
    uint fragment_count;
};

void append(vec4 color, uint key) {
    uint node = atomicAdd(fragment_count, 1u);
    if (node < abuffer.capacity) {
        const uint TEXELS = NODE_FORMAT == NODE_COMPACT ? 1u : 2u;
        uint next = imageAtomicExchange(heads, ivec2(gl_FragCoord.xy), node);
        imageStore(nodes, node_texel(node * TEXELS), pack_node(gl_FragCoord.z, key, color, next));
        if (TEXELS > 1u) {
            imageStore(nodes, node_texel(node * TEXELS + 1u), pack_node_rest(color, next));
        }
    }
}
