#version 460
#extension GL_EXT_scalar_block_layout : require
#include "voxel/vote/leak.glsl"

// Whether each voxel is inside, from what its columns along the three axes say: the majority of those that do not leak.
// Where these are at odds, or none is left, the others count too. An invocation makes a word of a column along z.

layout(local_size_x = 8, local_size_y = 8) in;

layout(push_constant, scalar) uniform VotePush {
    uvec3 size; // voxels along x, y, z
};
layout(set = 0, binding = 2, scalar) readonly buffer AlongX {
    uint along_x[];
};
layout(set = 0, binding = 3, scalar) readonly buffer AlongY {
    uint along_y[];
};
layout(set = 0, binding = 4, scalar) readonly buffer AlongZ {
    uint along_z[];
};
layout(set = 0, binding = 5, scalar) readonly buffer CrossingsX {
    int crossings_x[];
};
layout(set = 0, binding = 6, scalar) readonly buffer CrossingsY {
    int crossings_y[];
};
layout(set = 0, binding = 7, scalar) readonly buffer CrossingsZ {
    int crossings_z[];
};
layout(set = 0, binding = 8, scalar) writeonly buffer Bits {
    uint bits[];
};

// A sound column weighs more than two that leak.
int votes(uint word, uint bit, int crossings) {
    int weight = is_leak(crossings) ? 1 : 3;
    return (word >> bit & 1u) != 0u ? weight : -weight;
}

void main() {
    uvec3 place = gl_GlobalInvocationID;
    if (any(greaterThanEqual(place.xy, size.xy)) || 32u * place.z >= size.z) {
        return;
    }
    uint index = (place.z * size.y + place.y) * size.x + place.x;
    uint own = along_z[index];
    int own_crossings = crossings_z[place.y * size.x + place.x];
    uint end = min(32u, size.z - 32u * place.z);
    uint inside = 0u;
    for (uint bit = 0u; bit < end; ++bit) {
        uint z = 32u * place.z + bit;
        // Columns along x stand at (y, z), those along y at (z, x).
        uint x_column = z * size.y + place.y;
        uint y_column = place.x * size.z + z;
        int sum = votes(own, bit, own_crossings);
        sum += votes(along_x[place.x / 32u * size.z * size.y + x_column], place.x % 32u, crossings_x[x_column]);
        sum += votes(along_y[place.y / 32u * size.x * size.z + y_column], place.y % 32u, crossings_y[y_column]);
        inside |= uint(sum > 0) << bit;
    }
    bits[index] = inside;
}
