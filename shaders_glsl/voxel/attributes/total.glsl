// How many voxels are set, and the workgroups of 64 that take one each.
layout(set = 0, binding = 14, scalar) TOTAL_ACCESS buffer Total {
    uint total;
    uint group_count[3];
};
