// Reading nodes, of arrays or of lists.

layout(constant_id = 6) const bool LINKED = false;

layout(set = 0, binding = 22, rgba32ui) readonly uniform uimage2D nodes;

uint node_texels() {
    if (NODE_FORMAT == NODE_HALF) {
        return LINKED ? 2u : 1u;
    }
    return NODE_FORMAT == NODE_FLOAT ? 2u : 1u;
}

uvec4 node_at(uint node) {
    return imageLoad(nodes, node_texel(node * node_texels()));
}

// What follows `node`, whose first texel is `texel`.
uint node_after(uint node, uvec4 texel) {
    if (!LINKED) {
        return node + 1u;
    }
    if (NODE_FORMAT == NODE_HALF) {
        return imageLoad(nodes, node_texel(node * node_texels() + 1u)).x;
    }
    return NODE_FORMAT == NODE_FLOAT ? texel.z : texel.w;
}

// A key as a signed number that sorts as it does.
int signed_key(uint key) {
    return int(key ^ 0x80000000u);
}

// Colour of a node of which only `payload` was kept.
vec4 node_color(int key, uvec2 payload) {
    uvec4 rest = NODE_FORMAT == NODE_FLOAT ? imageLoad(nodes, node_texel(payload.x * node_texels() + 1u)) : uvec4(0u);
    return unpack_color(uvec4(0u, uint(key) ^ 0x80000000u, payload), rest);
}

// What a register keeps besides depth and key: the colour, or for floats where it is.
uvec2 node_payload(uint node, uvec4 texel) {
    return NODE_FORMAT == NODE_FLOAT ? uvec2(node, 0u) : texel.zw;
}

// Whether a colour stands at the end of what its format can hold.
bool is_clamped(uvec2 payload) {
    if (NODE_FORMAT == NODE_COMPACT) {
        uvec3 m = uvec3(payload.x & 511u, payload.x >> 9 & 511u, payload.x >> 18 & 511u);
        return payload.x >> 27 == 31u && any(equal(m, uvec3(511u)));
    }
    uvec3 halves = uvec3(payload.x & 0xffffu, payload.x >> 16, payload.y & 0xffffu);
    return NODE_FORMAT == NODE_HALF && any(equal(halves, uvec3(0x7bffu)));
}
