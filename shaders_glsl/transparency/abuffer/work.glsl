// Pixels that have nodes, class by class.
#include "transparency/abuffer/scan.glsl"
#include "transparency/abuffer/totals.glsl"

struct Pixel {
    uint at; // x, y · 2^16
    uint first; // its first node: in arrays as `place`, in lists the head
    uint place; // nodes of all pixels before
    uint count;
};

ivec2 pixel_at(Pixel pixel) {
    return ivec2(pixel.at & 0xffffu, pixel.at >> 16);
}

layout(set = 0, binding = 4, scalar) WORK_ACCESS buffer Work {
    Pixel work[]; // there may be room for more
};

uint work_count() {
    return total.pixels[0] + total.pixels[1] + total.pixels[2] + total.pixels[3];
}
