// Reading nodes, of arrays or of lists.

layout(constant_id = 6) const bool LINKED = false;

layout(set = 0, binding = 22, rgba32ui) readonly uniform uimage2D nodes;
layout(set = 0, binding = 25, r32ui) readonly uniform uimage2D beside; // words of nodes

// Whether a node's colour does not fit into its first texel: then a register keeps where the node is.
const bool KEEPS_PLACE = NODE_TEXELS > 1u || TINT_BESIDE;

uvec4 node_at(uint node, uint texel) {
    return imageLoad(nodes, node_texel(node * NODE_TEXELS + texel));
}

uvec4 node_at(uint node) {
    return node_at(node, 0u);
}

// What follows `node`, whose first texel is `texel`.
uint node_after(uint node, uvec4 texel) {
    if (!LINKED) {
        return node + 1u;
    }
    if (LINK_BESIDE) {
        return imageLoad(beside, node_texel(link_word(node))).x;
    }
    return NODE_FORMAT == NODE_COMPACT ? texel.w : texel.z;
}

// A key as a signed number that sorts as it does.
int signed_key(uint key) {
    return int(key ^ 0x80000000u);
}

// Layer of a node of which only `payload` was kept.
Layer node_layer(int key, uvec2 payload) {
    uvec4 rest = uvec4(0u);
    if (NODE_TEXELS > 1u) {
        rest = node_at(payload.x, 1u);
    } else if (TINT_BESIDE) {
        rest = imageLoad(beside, node_texel(tint_word(payload.x, LINKED)));
    }
    uvec2 words = KEEPS_PLACE ? node_at(payload.x).zw : payload;
    return unpack_node(uvec4(0u, uint(key) ^ 0x80000000u, words), rest);
}

// What a register keeps besides depth and key: the colour, or where it is.
uvec2 node_payload(uint node, uvec4 texel) {
    return KEEPS_PLACE ? uvec2(node, 0u) : texel.zw;
}

// Whether a colour stands at the end of what its format can hold.
bool is_clamped(uvec2 payload) {
    if (NODE_FORMAT == NODE_COMPACT || NODE_FORMAT == NODE_COMPACT_TINTED) {
        uvec3 m = uvec3(payload.x & 511u, payload.x >> 9 & 511u, payload.x >> 18 & 511u);
        return all(bvec2(payload.x >> 27 == 31u, any(equal(m, uvec3(511u)))));
    }
    uvec2 words = TINT_BESIDE ? node_at(payload.x).zw : payload;
    uvec3 halves = uvec3(words.x & 0xffffu, words.x >> 16, words.y & 0xffffu);
    return (NODE_FORMAT == NODE_HALF || TINT_BESIDE) && any(equal(halves, uvec3(0x7bffu)));
}
