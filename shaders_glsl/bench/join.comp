#version 460

// The sum of two images: passes that form a tree.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32ui) readonly uniform uimage2D left;
layout(set = 0, binding = 1, r32ui) readonly uniform uimage2D right;
layout(set = 0, binding = 2, r32ui) writeonly uniform uimage2D sum;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    imageStore(sum, pixel, uvec4(imageLoad(left, pixel).r + imageLoad(right, pixel).r));
}
