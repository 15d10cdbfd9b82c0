// Size of what is built: the whole picture, or a band of its rows.
layout(set = 0, binding = 21, scalar) uniform ABufferFrame {
    uvec2 size; // pixels
    uint first_row;
    uint capacity; // nodes
    uint used; // 0: these lists came out too short, and others stand in
} abuffer;

// Pixels are numbered row by row.
ivec2 pixel_of(uint index) {
    return ivec2(index % abuffer.size.x, index / abuffer.size.x + abuffer.first_row);
}

// The pixel of the next number: without a division, which software drivers do lane by lane.
ivec2 next_pixel(ivec2 pixel) {
    ivec2 next = pixel + ivec2(1, 0);
    return mix(next, ivec2(0, next.y + 1), bvec2(next.x == int(abuffer.size.x)));
}
