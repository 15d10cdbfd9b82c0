// Where each pixel's nodes begin, and the list of pixels that have some.
#extension GL_EXT_samplerless_texture_functions : require
#define WORK_ACCESS writeonly
#include "transparency/abuffer/frame.glsl"
#include "transparency/abuffer/work.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 1, scalar) readonly buffer Chunks {
    Sums chunks[];
};
layout(set = 0, binding = 2, scalar) readonly buffer Groups {
    Sums groups[];
};
#ifdef LISTS
layout(set = 0, binding = 23, r32ui) readonly uniform uimage2D heads;
#else
layout(set = 0, binding = 23, r32ui) writeonly uniform uimage2D cursors;
#endif

void main() {
    uint chunk = gl_GlobalInvocationID.x;
    uint pixels = abuffer.size.x * abuffer.size.y;
    uint first = chunk * CHUNK;
    if (first >= pixels) {
        return;
    }
    uint end = min(first + CHUNK, pixels);
    Sums before = add(groups[chunk / GROUP], chunks[chunk]);
    // Classes stand one after the other.
    uvec4 place = uvec4(before.pixels[0], before.pixels[1], before.pixels[2], before.pixels[3]);
    place.y += total.pixels[0];
    place.z += total.pixels[0] + total.pixels[1];
    place.w += total.pixels[0] + total.pixels[1] + total.pixels[2];
    uint node = before.nodes;
    ivec2 at = pixel_of(first);
    for (uint pixel = first; pixel < end; ++pixel) {
        uint count = uint(texelFetch(counts, at, 0).r) * abuffer.used;
        uint own = class_of(count);
        uint to = own == 0u ? place.x : own == 1u ? place.y : own == 2u ? place.z : place.w;
        uint packed = uint(at.x | at.y << 16);
        if (count > 0u) {
#ifdef LISTS
            work[to] = Pixel(packed, imageLoad(heads, at).r, node, count);
#else
            work[to] = Pixel(packed, node, node, count);
            imageStore(cursors, at, uvec4(node));
#endif
        }
        place += uvec4(equal(uvec4(own), uvec4(0u, 1u, 2u, 3u))) * uint(count > 0u);
        node += count;
        at = next_pixel(at);
    }
}
