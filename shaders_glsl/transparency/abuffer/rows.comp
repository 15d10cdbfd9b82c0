#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/abuffer/scan.glsl"

// What each row of the picture holds, so that the host can part it into bands.

layout(local_size_x = 8) in;

struct Row {
    uint nodes;
    uint longest; // most nodes of a pixel
};

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 1, scalar) writeonly buffer Rows {
    Row rows[];
};

void main() {
    uint y = gl_GlobalInvocationID.x;
    ivec2 size = textureSize(counts, 0);
    if (y >= uint(size.y)) {
        return;
    }
    Row row = Row(0u, 0u);
    for (int x = 0; x < size.x; ++x) {
        uint count = uint(texelFetch(counts, ivec2(x, y), 0).r);
        row = Row(add_nodes(row.nodes, count), max(row.longest, count));
    }
    rows[y] = row;
}
