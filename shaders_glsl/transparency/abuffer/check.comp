#version 460
#extension GL_EXT_scalar_block_layout : require
#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/report.glsl"

// Whether each pixel's array was filled to its end: as many nodes as were counted, no more and no less.

layout(local_size_x = 64) in;

layout(set = 0, binding = 23, scalar) readonly buffer Cursors {
    uint cursors[];
};
void main() {
    uint place = work_index();
    if (place >= work_count()) {
        return;
    }
    Pixel pixel = work[place];
    if (cursors[pixel.index] != pixel.place + pixel.count) {
        atomicAdd(report.lost_pixels, 1u);
    }
}
