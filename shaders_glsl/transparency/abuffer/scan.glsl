// Prefix sums over the pixels' counts, in three steps: chunks of pixels, groups of chunks, all groups. An invocation
// runs over its own part without a barrier: on software drivers much faster than a scan in shared memory.

const uint CHUNK = 256u; // pixels
const uint GROUP = 256u; // chunks

// Pixels are told apart by how many nodes they have: up to 4, up to 8, up to 16, more.
const uint CLASSES = 4u;
const uint SHORT = 16u;

// Sums over a chunk or a group; after the scan, sums over all before it.
struct Sums {
    uint nodes;
    uint longest; // most nodes of a pixel
    uint pixels[CLASSES];
};

uint class_of(uint count) {
    return uint(count > 4u) + uint(count > 8u) + uint(count > SHORT);
}

// A sum that stays at the largest number: more than any device has room for.
uint add_nodes(uint a, uint b) {
    uint sum = a + b;
    return sum < a ? 0xffffffffu : sum;
}

Sums add(Sums a, Sums b) {
    Sums sum;
    sum.nodes = add_nodes(a.nodes, b.nodes);
    sum.longest = max(a.longest, b.longest);
    sum.pixels[0] = a.pixels[0] + b.pixels[0];
    sum.pixels[1] = a.pixels[1] + b.pixels[1];
    sum.pixels[2] = a.pixels[2] + b.pixels[2];
    sum.pixels[3] = a.pixels[3] + b.pixels[3];
    return sum;
}

const Sums NOTHING = Sums(0u, 0u, uint[4](0u, 0u, 0u, 0u));
