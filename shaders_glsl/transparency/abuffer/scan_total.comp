#version 460
#extension GL_EXT_scalar_block_layout : require
#define TOTALS_ACCESS writeonly
#include "transparency/abuffer/scan.glsl"
#include "transparency/abuffer/totals.glsl"

// Sums before each group, and over all.

layout(local_size_x = 1) in;

layout(set = 0, binding = 2, scalar) buffer Groups {
    Sums groups[];
};

void main() {
    Sums before = NOTHING;
    for (uint group = 0u; group < groups.length(); ++group) {
        Sums own = groups[group];
        groups[group] = before;
        before = add(before, own);
    }
    total = before;
    for (uint i = 0u; i < CLASSES; ++i) {
        class_groups[i] = groups_for(before.pixels[i]);
    }
    work_groups = groups_for(before.pixels[0] + before.pixels[1] + before.pixels[2] + before.pixels[3]);
    uvec3 longs = groups_for(before.pixels[CLASSES - 1u]);
    longs.z = (before.longest + SHORT - 1u) / SHORT;
    block_groups = sorted_in_place(before.longest) ? uvec3(0u) : longs;
    longs.z = (before.longest + RUN - 1u) / RUN;
    run_groups = sorted_in_place(before.longest) ? uvec3(0u) : longs;
    for (uint i = 0u; i < MERGES; ++i) {
        merge_groups[i] = before.longest > RUN << i ? longs : uvec3(0u);
    }
}
