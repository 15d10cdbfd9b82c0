#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/scan.glsl"
#include "transparency/abuffer/totals.glsl"
#include "transparency/abuffer/report.glsl"

// Whether all nodes that fragments asked for are in lists: the lists' lengths, summed up, against the counter.

layout(local_size_x = 1) in;

layout(set = 0, binding = 24, scalar) readonly buffer Counter {
    uint fragment_count;
};

void main() {
    if (abuffer.used != 0u && total.nodes != fragment_count) {
        report.lost_nodes += fragment_count - total.nodes;
    }
}
