#version 460
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/composite.glsl"

// Puts what was gathered over the opaque picture, where there is a layer.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
layout(set = 0, binding = 24, rgba32f) readonly uniform image2D front;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color))) || texelFetch(counts, pixel, 0).r == 0.0) {
        return;
    }
    imageStore(color, pixel, over_opaque(imageLoad(front, pixel), imageLoad(color, pixel)));
}
