// What the whole picture holds, and how much work that is: the workgroups of each pass that follows.

const uint WORKGROUP = 64u;
// Most workgroups in x: the rest goes to y.
const uint ROW = 32768u;

// Nodes that one invocation sorts, and puts out in a merge.
const uint RUN = 2048u;
// Runs of RUN nodes are merged this often, each time two to one.
const uint MERGES = 8u;

// How pixels of more nodes than fit into registers are sorted: in blocks that are merged, or, up to so many nodes, where
// they lie.
const uint SORT_BLOCKS = 0u;
const uint SORT_SHELL = 1u;
const uint SORT_HEAP = 2u;
const uint SORT_BITONIC = 3u;
layout(constant_id = 9) const uint LONG_SORT = SORT_BLOCKS;
const uint IN_PLACE_MOST = 512u;

bool sorted_in_place(uint count) {
    return LONG_SORT != SORT_BLOCKS && count <= IN_PLACE_MOST;
}

#ifndef TOTALS_ACCESS
#define TOTALS_ACCESS readonly
#endif
layout(set = 0, binding = 3, scalar) TOTALS_ACCESS buffer Totals {
    Sums total;
    uvec3 class_groups[CLASSES]; // by class, an invocation a pixel
    uvec3 work_groups; // an invocation a pixel that has nodes
    uvec3 block_groups; // an invocation 16 nodes of a long pixel
    uvec3 run_groups; // an invocation a run of a long pixel
    uvec3 merge_groups[MERGES]; // the same, where a pixel is long enough
};

uvec3 groups_for(uint invocations) {
    uint needed = (invocations + WORKGROUP - 1u) / WORKGROUP;
    return uvec3(min(needed, ROW), (needed + ROW - 1u) / ROW, 1u);
}

// The invocation's place in what `groups_for` covers.
uint work_index() {
    return (gl_WorkGroupID.y * ROW + gl_WorkGroupID.x) * WORKGROUP + gl_LocalInvocationID.x;
}
