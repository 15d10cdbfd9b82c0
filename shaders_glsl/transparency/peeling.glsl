// Which fragment of a pixel comes next: by depth, and of equal depth by the number of the triangle, larger ones first.
//
// The state of a pixel: the layer of this round (depth, tag) and the next other depth, which is known a round ahead. A
// fragment takes part in one of three searches at most, each of them a maximum: another tag at this layer's depth; the
// tag at the next depth; the depth after that. So one pass over all fragments peels a layer, ties and all, by 32-bit
// atomics.

const uint FIND_TIE = 0u;
const uint FIND_TAG = 1u;
const uint FIND_DEPTH = 2u;
const uint FIND_NOTHING = 3u;
const uint SEARCHES = 3u;

// Before all layers.
const uint PEEL_BEGIN = 0xffffffffu;

// Numbers that sort nearest first, none of them 0. Depth is reversed and positive: its bits sort as it does.
uvec2 peel_place(float depth, uint key) {
    return uvec2(floatBitsToUint(depth), key + 1u);
}

bool peel_before(uvec2 a, uvec2 b) {
    return a.x > b.x || (a.x == b.x && a.y > b.y);
}

// Which search a fragment takes part in, and with what.
uint peel_search(uvec4 state, uvec2 place, out uint value) {
    bool tie = place.x == state.x && place.y < state.y;
    bool tag = place.x == state.z;
    bool depth = place.x < state.z;
    value = depth ? place.x : place.y;
    return tie ? FIND_TIE : tag ? FIND_TAG : depth ? FIND_DEPTH : FIND_NOTHING;
}

// The next round's state.
uvec4 peel_next(uvec4 state, uint tie, uint tag, uint depth) {
    return tie > 0u ? uvec4(state.x, tie, state.z, 0u) : uvec4(state.z, tag, depth, 0u);
}
