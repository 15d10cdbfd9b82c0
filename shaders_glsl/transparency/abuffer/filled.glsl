// Whether a pixel's array was filled to its end: as many nodes as were counted, no more and no less. (list_check.comp is for
// lists.)

layout(set = 0, binding = 23, r32ui) readonly uniform uimage2D ends; // of arrays, where the next node would go

void check_filled(Pixel pixel, ivec2 at) {
    if (!LINKED && imageLoad(ends, at).r != pixel.place + pixel.count) {
        atomicAdd(report.lost_pixels, 1u);
    }
}
