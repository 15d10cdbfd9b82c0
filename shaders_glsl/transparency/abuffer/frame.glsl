// Size of what is built.
layout(set = 0, binding = 21, scalar) uniform ABufferFrame {
    uvec2 size; // pixels
    uint capacity; // nodes
    uint used; // 0: these lists came out too short, and others stand in
} abuffer;

uint pixel_index(uvec2 pixel) {
    return pixel.y * abuffer.size.x + pixel.x;
}
