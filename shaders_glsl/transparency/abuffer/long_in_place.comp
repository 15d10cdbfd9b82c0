#version 460
#extension GL_EXT_scalar_block_layout : require
#include "transparency/abuffer/long.glsl"
#include "transparency/abuffer/nodes_read.glsl"

// Sorts a pixel's nodes where they lie, an invocation a pixel, by one of three methods. Lists are so short that none
// takes 65,535 turns, after which lavapipe 22 ends loops.

layout(local_size_x = 64) in;

layout(set = 0, binding = 7, rgba32ui) uniform uimage2D sorted;

// Of the pixel that is sorted.
uint first;
uint count;

uvec4 load(uint i) {
    return imageLoad(sorted, node_texel(first + i));
}

void store(uint i, uvec4 node) {
    imageStore(sorted, node_texel(first + i), node);
}

// Shell 1959, "A high-speed sorting procedure", with the gaps of Ciura 2001. With 512 nodes no order takes more than
// 48,000 turns: no node has more inversions at a gap than sums of the two gaps before it leave out.
const uint GAPS[7] = uint[7](301u, 132u, 57u, 23u, 10u, 4u, 1u);

void shell_sort() {
    for (uint g = 0u; g < 7u; ++g) {
        uint gap = GAPS[g];
        for (uint i = gap; i < count; ++i) {
            uvec4 node = load(i);
            uint j = i;
            uvec4 other = load(i - gap);
            while (j >= gap && in_front(node, other)) {
                store(j, other);
                j -= gap;
                other = load(max(j, gap) - gap);
            }
            store(j, node);
        }
    }
}

// Lets a node sink from `hole` in a heap of `size` nodes whose hindmost is on top.
void sink(uint hole, uint size, uvec4 node) {
    uint child = 2u * hole + 1u;
    while (child < size) {
        uvec4 left = load(child);
        uvec4 right = load(min(child + 1u, size - 1u));
        bool take_right = in_front(left, right);
        uvec4 larger = take_right ? right : left;
        if (!in_front(node, larger)) {
            break;
        }
        store(hole, larger);
        hole = child + uint(take_right);
        child = 2u * hole + 1u;
    }
    store(hole, node);
}

// Williams 1964, "Algorithm 232: heapsort".
void heap_sort() {
    for (uint i = count / 2u; i > 0u; --i) {
        sink(i - 1u, count, load(i - 1u));
    }
    for (uint last = count - 1u; last > 0u; --last) {
        uvec4 node = load(last);
        store(last, load(0u));
        sink(0u, last, node);
    }
}

// Batcher 1968, the bitonic sorter with all comparisons one way: what is missing to a power of two would stay behind.
void bitonic_sort() {
    uint width = 1u << (findMSB(count - 1u) + 1);
    for (uint block = 2u; block <= width; block *= 2u) {
        for (uint step = block / 2u; step > 0u; step /= 2u) {
            for (uint pair = 0u; pair < width / 2u; ++pair) {
                uint a = 2u * step * (pair / step) + pair % step;
                // The first step of a block compares mirrored places.
                uint b = step == block / 2u ? (a | (block - 1u)) - pair % step : a + step;
                if (b < count) {
                    uvec4 front = load(a);
                    uvec4 behind = load(b);
                    if (in_front(behind, front)) {
                        store(a, behind);
                        store(b, front);
                    }
                }
            }
        }
    }
}

void main() {
    Pixel pixel;
    if (!long_pixel(work_index(), pixel) || !sorted_in_place(pixel.count)) {
        return;
    }
    first = pixel.place;
    count = pixel.count;
    uint node = pixel.first;
    for (uint i = 0u; i < count; ++i) {
        uvec4 texel = node_at(node);
        store(i, uvec4(texel.xy, node_payload(node, texel)));
        node = node_after(node, texel);
    }
    if (LONG_SORT == SORT_SHELL) {
        shell_sort();
    } else if (LONG_SORT == SORT_HEAP) {
        heap_sort();
    } else {
        bitonic_sort();
    }
}
