// Nodes: what the A-buffer keeps of a fragment (Carpenter 1984), in texels of four 32-bit words. An image holds them:
// software drivers load a texel at once, but a buffer's words one by one for each lane.
//
//   format             texels   words
//   compact            1        depth; key (24 bits) and alpha (8); red, green, blue (9·9·9) and exponent (5); next
//   half               1        depth; key; red, green (16·16); blue, alpha (16·16)
//   float              2        depth; key; next; 0  |  red; green; blue; alpha
//   compact, tinted    1        depth; key; red, green, blue (9·9·9) and exponent (5); through (10·10·10)
//   float, tinted      2        depth; key; through red; green  |  red; green; blue; through blue
//   transmittance      1        depth; key; through (21·21·21, in two words): no colour
//   half, tinted       1        depth; key; red, green (16·16); blue, through red (16·16); beside: through green, blue (16·16)
//
// Where pixels have several samples, the key of every format is 24 bits before 8 of samples, and the alpha of compact nodes
// stands in place of `next`.
//
// `next` is there in lists. Lists of the formats that do not show it have it beside the node. What is beside nodes is in an
// image of single words: of each node `next`, where that is there, then the tint. Depth is reversed and
// not negative, so that its bits sort as it does. Of equal depth the larger key is in front.

#include "transparency/composite.glsl"
#include "transparency/abuffer/samples.glsl"

const uint NODE_COMPACT = 0u;
const uint NODE_HALF = 1u;
const uint NODE_FLOAT = 2u;
const uint NODE_COMPACT_TINTED = 3u;
const uint NODE_FLOAT_TINTED = 4u;
const uint NODE_TRANSMITTANCE = 5u;
const uint NODE_HALF_TINTED = 6u;

layout(constant_id = 3) const uint NODE_FORMAT = NODE_COMPACT;
// Colours are stored as multiples of this, a power of two.
layout(constant_id = 4) const float NODE_UNIT = 1.0;

// Texels of a row of the nodes' image.
const uint NODE_ROW_BITS = 12u;
const uint NODE_ROW = 1u << NODE_ROW_BITS;

const uint NODE_TEXELS = NODE_FORMAT == NODE_FLOAT || NODE_FORMAT == NODE_FLOAT_TINTED ? 2u : 1u;
// Whether `next` is beside the node, and part of what it lets through.
const bool LINK_BESIDE = (NODE_FORMAT != NODE_COMPACT || SAMPLES > 1u) && NODE_FORMAT != NODE_FLOAT;

const bool TINT_BESIDE = NODE_FORMAT == NODE_HALF_TINTED;

uint link_word(uint node) {
    return TINT_BESIDE ? 2u * node : node;
}

uint tint_word(uint node, bool linked) {
    return linked ? 2u * node + 1u : node;
}

ivec2 node_texel(uint texel) {
    return ivec2(texel & (NODE_ROW - 1u), texel >> NODE_ROW_BITS);
}

// By the first texels of two nodes.
bool in_front(uvec4 a, uvec4 b) {
    return a.x > b.x || (a.x == b.x && a.y > b.y);
}

// No node: the end of a list.
const uint NO_NODE = 0xffffffffu;

// Largest value of RGB9E5 (EXT_texture_shared_exponent).
const float SHARED_EXPONENT_MAX = 65408.0;
const float HALF_MAX = 65504.0;

// Numbers below 2^31 are converted as signed ones: one instruction.
uint pack_shared_exponent(vec3 rgb) {
    vec3 c = clamp(rgb, 0.0, SHARED_EXPONENT_MAX);
    float largest = max(max(c.r, c.g), c.b);
    // Exponent of the largest component; one more where it rounds up to the next power of two.
    int exponent = max(int(floatBitsToUint(largest) >> 23) - 127, -16) + 1;
    float scale = uintBitsToFloat(uint(9 - exponent + 127) << 23);
    bool up = floor(largest * scale + 0.5) == 512.0;
    exponent += up ? 1 : 0;
    scale *= up ? 0.5 : 1.0;
    uvec3 m = uvec3(ivec3(c * scale + 0.5));
    return m.r | m.g << 9 | m.b << 18 | uint(exponent + 15) << 27;
}

vec3 unpack_shared_exponent(uint word) {
    float scale = uintBitsToFloat(((word >> 27) - 15u - 9u + 127u) << 23);
    return vec3(ivec3(word, word >> 9, word >> 18) & 511) * scale;
}

uint pack_alpha(float alpha) {
    return uint(int(clamp(alpha, 0.0, 1.0) * 255.0 + 0.5));
}

// Second word of a node, by which nodes of equal depth are told apart.
uint pack_key(uint key, float alpha, uint samples) {
    if (SAMPLES > 1u) {
        return key << SAMPLE_BITS | samples;
    }
    return NODE_FORMAT == NODE_COMPACT ? key << 8 | pack_alpha(alpha) : key;
}

// The samples that a node is seen at, from its second word.
uint node_samples(uint key) {
    return key & ((1u << SAMPLE_BITS) - 1u);
}

uint pack_through_10(vec3 through) {
    uvec3 steps = uvec3(ivec3(clamp(through, 0.0, 1.0) * 1023.0 + 0.5));
    return steps.r | steps.g << 10 | steps.b << 20;
}

vec3 unpack_through_10(uint word) {
    return vec3(ivec3(word, word >> 10, word >> 20) & 1023) * (1.0 / 1023.0);
}

const uint STEPS_21 = 0x1fffffu;

uvec2 pack_through_21(vec3 through) {
    uvec3 steps = uvec3(ivec3(clamp(through, 0.0, 1.0) * float(STEPS_21) + 0.5));
    return uvec2(steps.r | steps.g << 21, steps.g >> 11 | steps.b << 10);
}

vec3 unpack_through_21(uvec2 words) {
    uvec3 steps = uvec3(words.x & STEPS_21, (words.x >> 21 | words.y << 11) & STEPS_21, words.y >> 10 & STEPS_21);
    return vec3(ivec3(steps)) * (1.0 / float(STEPS_21));
}

// A texel of a node.
uvec4 pack_node(uint texel, Covered covered, uint key, Layer layer, uint next) {
    vec3 rgb = layer.rgb * (1.0 / NODE_UNIT);
    if (texel == 1u && NODE_FORMAT == NODE_FLOAT) {
        return floatBitsToUint(vec4(rgb, layer.alpha));
    }
    if (texel == 1u && NODE_FORMAT == NODE_FLOAT_TINTED) {
        return floatBitsToUint(vec4(rgb, layer.through.b));
    }
    uvec4 node = uvec4(floatBitsToUint(covered.depth), pack_key(key, layer.alpha, covered.samples), next, 0u);
    if (NODE_FORMAT == NODE_COMPACT) {
        node.zw = uvec2(pack_shared_exponent(rgb), SAMPLES > 1u ? pack_alpha(layer.alpha) : next);
    } else if (NODE_FORMAT == NODE_HALF) {
        rgb = clamp(rgb, 0.0, HALF_MAX);
        node.zw = uvec2(packHalf2x16(rgb.rg), packHalf2x16(vec2(rgb.b, layer.alpha)));
    } else if (NODE_FORMAT == NODE_COMPACT_TINTED) {
        node.zw = uvec2(pack_shared_exponent(rgb), pack_through_10(layer.through));
    } else if (NODE_FORMAT == NODE_FLOAT_TINTED) {
        node.zw = floatBitsToUint(layer.through.rg);
    } else if (NODE_FORMAT == NODE_HALF_TINTED) {
        rgb = clamp(rgb, 0.0, HALF_MAX);
        node.zw = uvec2(packHalf2x16(rgb.rg), packHalf2x16(vec2(rgb.b, layer.through.r)));
    } else if (NODE_FORMAT == NODE_TRANSMITTANCE) {
        node.zw = pack_through_21(layer.through);
    }
    return node;
}

// The word of it that is beside.
uint pack_tint(Layer layer) {
    return packHalf2x16(layer.through.gb);
}

// The layer of a node, from its first texel and, of formats that have it there, its second or the word beside.
Layer unpack_node(uvec4 node, uvec4 rest) {
    if (NODE_FORMAT == NODE_HALF_TINTED) {
        vec2 last = unpackHalf2x16(node.w);
        vec3 rgb = vec3(unpackHalf2x16(node.z), last.x);
        return tinted_layer(rgb * NODE_UNIT, vec3(last.y, unpackHalf2x16(rest.x)));
    }
    if (NODE_FORMAT == NODE_COMPACT_TINTED) {
        return tinted_layer(unpack_shared_exponent(node.z) * NODE_UNIT, unpack_through_10(node.w));
    }
    if (NODE_FORMAT == NODE_FLOAT_TINTED) {
        vec3 through = uintBitsToFloat(uvec3(node.zw, rest.w));
        return tinted_layer(uintBitsToFloat(rest.rgb) * NODE_UNIT, through);
    }
    if (NODE_FORMAT == NODE_TRANSMITTANCE) {
        return tinted_layer(vec3(0.0), unpack_through_21(node.zw));
    }
    vec4 color;
    if (NODE_FORMAT == NODE_COMPACT) {
        color = vec4(unpack_shared_exponent(node.z), float(int((SAMPLES > 1u ? node.w : node.y) & 255u)) * (1.0 / 255.0));
    } else if (NODE_FORMAT == NODE_HALF) {
        color = vec4(unpackHalf2x16(node.z), unpackHalf2x16(node.w));
    } else {
        color = uintBitsToFloat(rest);
    }
    return plain_layer(vec4(color.rgb * NODE_UNIT, color.a));
}
