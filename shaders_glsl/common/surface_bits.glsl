// What triangles make up becomes bits. Include after common/surface_voxels_small.glsl or common/surface_voxels_large.glsl.

layout(set = 0, binding = 2, scalar) buffer Bits {
    uint bits[];
};

void take(uvec2 column, uint word, uint found) {
    atomicOr(bits[word_index(column, word)], found);
}
