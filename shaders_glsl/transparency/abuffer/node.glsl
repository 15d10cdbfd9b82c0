// Nodes: what the A-buffer keeps of a fragment (Carpenter 1984), in texels of four 32-bit words. An image holds them:
// software drivers load a texel at once, but a buffer's words one by one for each lane.
//
//   format     texels    words
//   compact    1         depth; key (24 bits) and alpha (8); red, green, blue (9·9·9) and exponent (5); next
//   half       1         depth; key; red, green (16·16); blue, alpha (16·16)
//   float      2         depth; key; next; 0  |  red; green; blue; alpha
//
// `next` is there in lists. Lists of the half format have a second texel for it. Depth is reversed and not negative, so
// that its bits sort as it does. Of equal depth the larger key is in front.

#include "transparency/composite.glsl"

const uint NODE_COMPACT = 0u;
const uint NODE_HALF = 1u;
const uint NODE_FLOAT = 2u;

layout(constant_id = 3) const uint NODE_FORMAT = NODE_COMPACT;
// Colours are stored as multiples of this, a power of two.
layout(constant_id = 4) const float NODE_UNIT = 1.0;

// Texels of a row of the nodes' image.
const uint NODE_ROW = 4096u;

ivec2 node_texel(uint texel) {
    return ivec2(texel % NODE_ROW, texel / NODE_ROW);
}

// No node: the end of a list.
const uint NO_NODE = 0xffffffffu;

// Largest value of RGB9E5 (EXT_texture_shared_exponent).
const float SHARED_EXPONENT_MAX = 65408.0;
const float HALF_MAX = 65504.0;

uint pack_shared_exponent(vec3 rgb) {
    vec3 c = clamp(rgb, 0.0, SHARED_EXPONENT_MAX);
    float largest = max(max(c.r, c.g), c.b);
    // Exponent of the largest component; one more where it rounds up to the next power of two.
    int exponent = max(int(floatBitsToUint(largest) >> 23) - 127, -16) + 1;
    float scale = uintBitsToFloat(uint(9 - exponent + 127) << 23);
    bool up = floor(largest * scale + 0.5) == 512.0;
    exponent += up ? 1 : 0;
    scale *= up ? 0.5 : 1.0;
    uvec3 m = uvec3(c * scale + 0.5);
    return m.r | m.g << 9 | m.b << 18 | uint(exponent + 15) << 27;
}

vec3 unpack_shared_exponent(uint word) {
    float scale = uintBitsToFloat(((word >> 27) - 15u - 9u + 127u) << 23);
    return vec3(word & 511u, word >> 9 & 511u, word >> 18 & 511u) * scale;
}

// Second word of a node, by which nodes of equal depth are told apart.
uint pack_key(uint key, float alpha) {
    return NODE_FORMAT == NODE_COMPACT ? key << 8 | uint(clamp(alpha, 0.0, 1.0) * 255.0 + 0.5) : key;
}

// First texel of a node, of a premultiplied colour.
uvec4 pack_node(float depth, uint key, vec4 color, uint next) {
    vec3 rgb = color.rgb * (1.0 / NODE_UNIT);
    uvec4 node = uvec4(floatBitsToUint(depth), pack_key(key, color.a), next, 0u);
    if (NODE_FORMAT == NODE_COMPACT) {
        node.zw = uvec2(pack_shared_exponent(rgb), next);
    } else if (NODE_FORMAT == NODE_HALF) {
        rgb = clamp(rgb, 0.0, HALF_MAX);
        node.zw = uvec2(packHalf2x16(rgb.rg), packHalf2x16(vec2(rgb.b, color.a)));
    }
    return node;
}

// Second texel, of formats that have one.
uvec4 pack_node_rest(vec4 color, uint next) {
    if (NODE_FORMAT == NODE_HALF) {
        return uvec4(next, 0u, 0u, 0u);
    }
    return floatBitsToUint(vec4(color.rgb * (1.0 / NODE_UNIT), color.a));
}

// Premultiplied colour from a node's texels.
vec4 unpack_color(uvec4 node, uvec4 rest) {
    vec4 color;
    if (NODE_FORMAT == NODE_COMPACT) {
        color = vec4(unpack_shared_exponent(node.z), float(node.y & 255u) * (1.0 / 255.0));
    } else if (NODE_FORMAT == NODE_HALF) {
        color = vec4(unpackHalf2x16(node.z), unpackHalf2x16(node.w));
    } else {
        color = uintBitsToFloat(rest);
    }
    return vec4(color.rgb * NODE_UNIT, color.a);
}
