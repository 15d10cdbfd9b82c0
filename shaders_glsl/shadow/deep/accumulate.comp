#version 460
#include "transparency/abuffer/node.glsl"

// From sorted surfaces to the transmittance after each of them.

layout(local_size_x = 64) in;

layout(set = 0, binding = 5, rgba32f) readonly uniform image2D spans; // first, count, nearest, farthest
layout(set = 0, binding = 7, rgba32ui) uniform uimage2D steps; // nodes before: depth, key, what is let through

// Eight nodes a turn: lavapipe 22 ends loops after 65,535.
#define STEP if (done < count) { \
    ivec2 at = node_texel(first + done); \
    uvec4 node = imageLoad(steps, at); \
    through *= unpack_through_21(node.zw); \
    imageStore(steps, at, uvec4(node.x, floatBitsToUint(through))); \
    ++done; \
}

void main() {
    ivec2 texel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(texel, imageSize(spans)))) {
        return;
    }
    vec4 span = imageLoad(spans, texel);
    uint first = uint(span.x);
    uint count = uint(span.y);
    vec3 through = vec3(1.0);
    uint done = 0u;
    while (done < count) {
        STEP STEP STEP STEP STEP STEP STEP STEP
    }
}
