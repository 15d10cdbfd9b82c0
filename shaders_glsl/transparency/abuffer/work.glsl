// Pixels that have nodes, class by class.
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/scan.glsl"
#include "transparency/abuffer/totals.glsl"

struct Pixel {
    uint index; // y · width + x
    uint first; // its first node: in arrays as `place`, in lists the head
    uint place; // nodes of all pixels before
    uint count;
};

layout(set = 0, binding = 4, scalar) WORK_ACCESS buffer Work {
    Pixel work[];
};

ivec2 pixel_of(uint index) {
    return ivec2(index % abuffer.size.x, index / abuffer.size.x);
}
