#version 460
#extension GL_EXT_scalar_block_layout : require

// A pass that costs next to nothing: what it takes is what passes take.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) readonly uniform uimage2D from;
layout(set = 0, binding = 1, r32ui) writeonly uniform uimage2D to;

layout(push_constant, scalar) uniform ChainPush {
    uint added;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(to, pixel, uvec4(imageLoad(from, pixel).r + push.added));
}
