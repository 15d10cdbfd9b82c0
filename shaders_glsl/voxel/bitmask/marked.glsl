// Which voxel of its column a fragment marks, and whether that is all it sets.

layout(location = 0) in float depth; // voxels

layout(constant_id = 1) const bool SURFACE = false; // the voxel that holds the surface; else the first one behind it

// May be one that the column does not have.
int marked_voxel() {
    return SURFACE ? int(floor(clamp(depth, -1.0, float(columns.z)))) : max(first_voxel_behind(depth), 0);
}

// Bits of a word that a fragment sets or flips.
uint marked_bits(int voxel, uint word) {
    return SURFACE ? uint(voxel >> 5 == int(word)) << (voxel & 31) : bits_from(voxel, word);
}
