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
    uint along_x[]; // turned
};
layout(set = 0, binding = 3, scalar) readonly buffer AlongY {
    uint along_y[]; // turned
};
layout(set = 0, binding = 4, scalar) readonly buffer AlongZ {
    uint along_z[];
};
layout(set = 0, binding = 5, scalar) readonly buffer SoundX {
    uint sound_x[];
};
layout(set = 0, binding = 6, scalar) readonly buffer SoundY {
    uint sound_y[];
};
layout(set = 0, binding = 7, scalar) readonly buffer CrossingsZ {
    int crossings_z[];
};
layout(set = 0, binding = 8, scalar) writeonly buffer Bits {
    uint bits[];
};

void main() {
    uvec3 place = gl_GlobalInvocationID; // z in words
    if (any(greaterThanEqual(place.xy, size.xy)) || 32u * place.z >= size.z) {
        return;
    }
    uint index = (place.z * size.y + place.y) * size.x + place.x;
    uint x = along_x[index];
    uint y = along_y[index];
    uint z = along_z[index];
    uint x_is_sound = sound_x[place.z * size.y + place.y];
    uint y_is_sound = sound_y[place.z * size.x + place.x];
    uint z_is_sound = is_leak(crossings_z[place.y * size.x + place.x]) ? 0u : 0xffffffffu;
    // Of two sound columns at odds, the third one makes the majority.
    uint majority = x & y | y & z | z & x;
    uint one_is_sound = (x_is_sound ^ y_is_sound ^ z_is_sound) & ~(x_is_sound & y_is_sound & z_is_sound);
    uint its_vote = x & x_is_sound | y & y_is_sound | z & z_is_sound;
    bits[index] = one_is_sound & its_vote | ~one_is_sound & majority;
}
