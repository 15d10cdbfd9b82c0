// Writing nodes, of arrays or of lists.
#include "transparency/abuffer/node.glsl"
#include "transparency/abuffer/covered.glsl"

layout(set = 0, binding = 22, rgba32ui) writeonly uniform uimage2D nodes;

// The fragment's node.
void store_node(uint node, Covered covered, uint key, Layer layer, uint next) {
    uint texel = node * NODE_TEXELS;
    imageStore(nodes, node_texel(texel), pack_node(0u, covered, key, layer, next));
    if (NODE_TEXELS > 1u) {
        imageStore(nodes, node_texel(texel + 1u), pack_node(1u, covered, key, layer, next));
    }
}
