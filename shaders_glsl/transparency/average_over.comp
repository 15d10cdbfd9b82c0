#version 460
#extension GL_EXT_samplerless_texture_functions : require
#include "transparency/average.glsl"
#include "transparency/composite.glsl"

// The average layer over the opaque picture.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 0) uniform texture2D sums;
layout(set = 0, binding = 1) uniform texture2D weights;
layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color)))) {
        return;
    }
    vec4 sum = texelFetch(sums, pixel, 0);
    float weight = texelFetch(weights, pixel, 0).r;
    if (weight == 0.0) {
        return;
    }
    vec4 front = vec4(0.0, 0.0, 0.0, 1.0);
    put_behind(front, average_layer(sum.rgb, weight, sum.a));
    imageStore(color, pixel, over_opaque(front, imageLoad(color, pixel)));
}
