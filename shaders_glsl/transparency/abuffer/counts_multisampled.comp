#version 460

// What fragments counted, as floats.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0, r32f) writeonly uniform image2D counts;
layout(set = 0, binding = 22, r32ui) readonly uniform uimage2D fragment_counts;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (all(lessThan(pixel, imageSize(counts)))) {
        imageStore(counts, pixel, vec4(float(imageLoad(fragment_counts, pixel).r)));
    }
}
