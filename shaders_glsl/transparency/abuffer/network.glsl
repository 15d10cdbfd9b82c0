// Up to 16 nodes in registers, nearest first, by a sorting network (Batcher 1968, odd-even merge sort): no branch, no
// indexed memory, the same steps for all lanes of a vector. Loops over all slots are unrolled by drivers, after what
// other formats of nodes need has gone from their bodies: written out here, pipelines take twice as long to make.

#extension GL_EXT_control_flow_attributes : require

layout(constant_id = 5) const uint SLOTS = 16u; // 4, 8 or 16

// Depth and key as signed numbers that sort as they do, and what else is needed of the node. Empty slots lie behind everything.
int slot_depth[16];
int slot_key[16];
uvec2 slot_payload[16];

#define FRONT_FIRST(i, j) { \
    int d = slot_depth[i]; \
    int k = slot_key[i]; \
    uvec2 p = slot_payload[i]; \
    bool swap = mix(slot_depth[j] > d, slot_key[j] > k, slot_depth[j] == d); \
    slot_depth[i] = mix(d, slot_depth[j], swap); \
    slot_key[i] = mix(k, slot_key[j], swap); \
    slot_payload[i] = mix(p, slot_payload[j], bvec2(swap)); \
    slot_depth[j] = mix(slot_depth[j], d, swap); \
    slot_key[j] = mix(slot_key[j], k, swap); \
    slot_payload[j] = mix(slot_payload[j], p, bvec2(swap)); \
}

#define SORT_4(a) \
    FRONT_FIRST(a, a + 1) FRONT_FIRST(a + 2, a + 3) \
    FRONT_FIRST(a, a + 2) FRONT_FIRST(a + 1, a + 3) \
    FRONT_FIRST(a + 1, a + 2)

#define MERGE_8(a) \
    FRONT_FIRST(a, a + 4) FRONT_FIRST(a + 1, a + 5) FRONT_FIRST(a + 2, a + 6) FRONT_FIRST(a + 3, a + 7) \
    FRONT_FIRST(a + 2, a + 4) FRONT_FIRST(a + 3, a + 5) \
    FRONT_FIRST(a + 1, a + 2) FRONT_FIRST(a + 3, a + 4) FRONT_FIRST(a + 5, a + 6)

#define MERGE_16 \
    FRONT_FIRST(0, 8) FRONT_FIRST(1, 9) FRONT_FIRST(2, 10) FRONT_FIRST(3, 11) \
    FRONT_FIRST(4, 12) FRONT_FIRST(5, 13) FRONT_FIRST(6, 14) FRONT_FIRST(7, 15) \
    FRONT_FIRST(4, 8) FRONT_FIRST(5, 9) FRONT_FIRST(6, 10) FRONT_FIRST(7, 11) \
    FRONT_FIRST(2, 4) FRONT_FIRST(3, 5) FRONT_FIRST(6, 8) FRONT_FIRST(7, 9) \
    FRONT_FIRST(10, 12) FRONT_FIRST(11, 13) \
    FRONT_FIRST(1, 2) FRONT_FIRST(3, 4) FRONT_FIRST(5, 6) FRONT_FIRST(7, 8) FRONT_FIRST(9, 10) \
    FRONT_FIRST(11, 12) FRONT_FIRST(13, 14)

void sort_slots() {
    SORT_4(0)
    if (SLOTS > 4u) {
        SORT_4(4) MERGE_8(0)
    }
    if (SLOTS > 8u) {
        SORT_4(8) SORT_4(12) MERGE_8(8) MERGE_16
    }
}

// Whether a pixel of the class of so many slots is at `place` of its class.
bool short_pixel(uint place, out Pixel pixel) {
    const uint CLASS = SLOTS == 4u ? 0u : SLOTS == 8u ? 1u : 2u;
    uint before = (CLASS > 0u ? total.pixels[0] : 0u) + (CLASS > 1u ? total.pixels[1] : 0u);
    bool there = place < total.pixels[CLASS];
    pixel = work[before + (there ? place : 0u)];
    return there;
}

// Loads the nodes of a pixel.
void load_slots(Pixel pixel) {
    uint node = pixel.first;
    [[unroll]] for (uint i = 0u; i < SLOTS; i++) {
        uvec4 texel = node_at(node);
        slot_depth[i] = mix(-1, int(texel.x), i < pixel.count);
        slot_key[i] = signed_key(texel.y);
        slot_payload[i] = node_payload(node, texel);
        node = mix(node, node_after(node, texel), i < pixel.count);
    }
}

// A slot's node, as it is kept once it is sorted.
uvec4 slot_node(uint i) {
    return uvec4(slot_depth[i], uint(slot_key[i]) ^ 0x80000000u, slot_payload[i]);
}
