// Size of what is built: the whole picture, or a band of its rows.
layout(set = 0, binding = 21, scalar) uniform ABufferFrame {
    uvec2 size; // pixels
    uint first_row;
    uint capacity; // nodes
    uint used; // 0: these lists came out too short, and others stand in
} abuffer;

uint pixel_index(uvec2 pixel) {
    return (pixel.y - abuffer.first_row) * abuffer.size.x + pixel.x;
}

ivec2 pixel_of(uint index) {
    return ivec2(index % abuffer.size.x, index / abuffer.size.x + abuffer.first_row);
}
