// Writing nodes, of arrays or of lists.
#include "transparency/abuffer/node.glsl"

layout(set = 0, binding = 22, rgba32ui) writeonly uniform uimage2D nodes;

// The fragment's node.
void store_node(uint node, uint key, Layer layer, uint next) {
    uint texel = node * NODE_TEXELS;
    imageStore(nodes, node_texel(texel), pack_node(0u, gl_FragCoord.z, key, layer, next));
    if (NODE_TEXELS > 1u) {
        imageStore(nodes, node_texel(texel + 1u), pack_node(1u, gl_FragCoord.z, key, layer, next));
    }
}
