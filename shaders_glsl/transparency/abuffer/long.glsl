// Pixels of more nodes than fit into registers. Blocks of 16 are sorted by the network, then merged two to one until
// one run is left, to and fro between two images: after an even number of merges the nodes are in the first.
#define WORK_ACCESS readonly
#include "transparency/abuffer/work.glsl"
#include "transparency/abuffer/node.glsl"

// Number of merges of `count` nodes. What is sorted in place is so in the second image.
uint merges_of(uint count) {
    return sorted_in_place(count) ? 1u : count > SHORT ? uint(findMSB(count - 1u)) - 3u : 0u;
}

// Whether a pixel of this class is at `place`.
bool long_pixel(uint place, out Pixel pixel) {
    uint before = total.pixels[0] + total.pixels[1] + total.pixels[2];
    bool there = place < total.pixels[3];
    pixel = work[before + (there ? place : 0u)];
    return there;
}
