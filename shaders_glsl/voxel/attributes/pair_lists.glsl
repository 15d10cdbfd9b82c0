// Lists of pairs. PAIR_ACCESS: how they are used.

layout(set = 0, binding = 15, scalar) PAIR_ACCESS buffer PairTriangles {
    uvec2 pair_triangles[]; // where the triangle's indices begin; its instance
};
layout(set = 0, binding = 16, scalar) PAIR_ACCESS buffer PairVoxels {
    uvec2 pair_voxels[]; // a voxel and its place among the set ones, packed
};

// Coordinates have 11 bits each, and there are less than 2^31 set voxels.
uvec2 pack_voxel(uvec3 voxel, uint rank) {
    return uvec2(voxel.x | voxel.y << 11 | voxel.z << 22, rank | (voxel.z >> 10) << 31);
}

uvec3 voxel_of(uvec2 code) {
    return uvec3(code.x & 0x7ffu, code.x >> 11 & 0x7ffu, code.x >> 22 | code.y >> 31 << 10);
}

uint rank_of(uvec2 code) {
    return code.y & 0x7fffffffu;
}
