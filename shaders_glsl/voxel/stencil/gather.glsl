#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/voxels.glsl"

// From a slab of slices to bits: a layer a slice, or with TILED a tile of one layer; 32 slices a word.

layout(local_size_x = 8, local_size_y = 8) in;

layout(push_constant, scalar) uniform SlabPush {
    uint first_word;
    uint slices;
    uint across; // tiles side by side
};
layout(set = 0, binding = 2, scalar) writeonly buffer Bits {
    uint bits[];
};
#ifdef TILED
layout(set = 0, binding = 3) uniform utexture2D stencil;
#define SLICE(column, slice) texelFetch(stencil, ivec2(uvec2((slice) % across, (slice) / across) * columns.xy + column), 0)
#else
layout(set = 0, binding = 3) uniform utexture2DArray stencil;
#define SLICE(column, slice) texelFetch(stencil, ivec3(column, slice), 0)
#endif

void main() {
    uvec2 column = gl_GlobalInvocationID.xy;
    uint word = gl_GlobalInvocationID.z;
    if (any(greaterThanEqual(column, columns.xy))) {
        return;
    }
    uint mask = 0u;
    uint end = min(32u, slices - 32u * word);
    for (uint bit = 0u; bit < end; ++bit) {
        mask |= uint(SLICE(column, 32u * word + bit).r != 0u) << bit;
    }
    bits[word_index(column, first_word + word)] = mask;
}
