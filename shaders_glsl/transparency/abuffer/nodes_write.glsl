// Writing nodes, of arrays or of lists.
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/covered.glsl"

layout(set = 0, binding = 22, rgba32ui) writeonly uniform uimage2D nodes;
layout(set = 0, binding = 25, r32ui) writeonly uniform uimage2D beside; // words of nodes

// The fragment's node.
void store_node(uint node, Covered covered, uint key, Layer layer, uint next, bool linked) {
    uint texel = node * NODE_TEXELS;
    imageStore(nodes, node_texel(texel), pack_node(0u, covered, key, layer, next));
    if (NODE_TEXELS > 1u) {
        imageStore(nodes, node_texel(texel + 1u), pack_node(1u, covered, key, layer, next));
    }
    if (linked && LINK_BESIDE) {
        imageStore(beside, node_texel(link_word(node)), uvec4(next));
    }
    if (TINT_BESIDE) {
        imageStore(beside, node_texel(tint_word(node, linked)), uvec4(pack_tint(layer)));
    }
}
