// Appends fragments to their pixels' linked lists (Yang et al. 2010, "Real-time concurrent linked list construction on
// the GPU"). A fragment shader that includes this tests depth early.
#include "transparency/abuffer/frame.glsl"

layout(early_fragment_tests) in;

#include "transparency/abuffer/nodes_write.glsl"
// By pixel, the node appended last.
layout(set = 0, binding = 23, r32ui) uniform uimage2D heads;
// Fragments so far, stored or not.
layout(set = 0, binding = 24, scalar) buffer Counter {
    uint fragment_count;
};

#ifdef BY_SUBGROUP
// Whether helper invocations take part in ballots.
layout(constant_id = 10) const bool HELPERS_VOTE = true;

// One addition for all fragments of a subgroup, each of which takes its own of the nodes.
uint take_node() {
    uvec4 taking = subgroupBallot(true);
    uint first = 0u;
    if (subgroupElect()) {
        first = atomicAdd(fragment_count, subgroupBallotBitCount(taking));
    }
    return subgroupBroadcastFirst(first) + subgroupBallotExclusiveBitCount(taking);
}
#else
uint take_node() {
    return atomicAdd(fragment_count, 1u);
}
#endif

void append(Layer layer, uint key) {
    Covered covered = fragment_covered();
#ifdef BY_SUBGROUP
    if (HELPERS_VOTE && gl_HelperInvocation) { // takes no node
        return;
    }
#endif
    uint node = take_node();
    if (node < abuffer.capacity) {
        uint next = imageAtomicExchange(heads, ivec2(gl_FragCoord.xy), node);
        store_node(node, covered, key, layer, next, true);
    }
}
