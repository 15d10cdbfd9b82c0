// The column mask behind the surface, for an XOR logic operation into TARGETS attachments of 128 voxels each, from a word of
// the column on. Of surfaces: the bit of the voxel that holds it, for OR.
#extension GL_EXT_scalar_block_layout : require
#include "common/voxels.glsl"
#include "voxel/bitmask/marked.glsl"

layout(push_constant, scalar) uniform TargetsPush {
    uint first_word;
};

layout(location = 0) out uvec4 words_0;
#if TARGETS > 1
layout(location = 1) out uvec4 words_1;
#endif
#if TARGETS > 2
layout(location = 2) out uvec4 words_2;
layout(location = 3) out uvec4 words_3;
#endif
#if TARGETS > 4
layout(location = 4) out uvec4 words_4;
layout(location = 5) out uvec4 words_5;
layout(location = 6) out uvec4 words_6;
layout(location = 7) out uvec4 words_7;
#endif

uvec4 words_from(int voxel, uint behind) {
    uint word = first_word + behind;
    return uvec4(
        marked_bits(voxel, word),
        marked_bits(voxel, word + 1u),
        marked_bits(voxel, word + 2u),
        marked_bits(voxel, word + 3u)
    );
}

void main() {
    int voxel = marked_voxel();
    words_0 = words_from(voxel, 0u);
#if TARGETS > 1
    words_1 = words_from(voxel, 4u);
#endif
#if TARGETS > 2
    words_2 = words_from(voxel, 8u);
    words_3 = words_from(voxel, 12u);
#endif
#if TARGETS > 4
    words_4 = words_from(voxel, 16u);
    words_5 = words_from(voxel, 20u);
    words_6 = words_from(voxel, 24u);
    words_7 = words_from(voxel, 28u);
#endif
}
