#version 460
#include "transparency/peeling.glsl"

// From the layers that were just composited to those found between them, until both ends meet.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 22, rgba32ui) uniform uimage2DArray peeled;
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray found;

uvec4 next(ivec2 pixel, uint end) {
    uint by_search[SEARCHES];
    for (uint search = 0u; search < SEARCHES; ++search) {
        ivec3 at = ivec3(pixel, end * SEARCHES + search);
        by_search[search] = imageLoad(found, at).r;
        imageStore(found, at, uvec4(0u));
    }
    uvec4 state = imageLoad(peeled, ivec3(pixel, end));
    return peel_next(state, by_search[FIND_TIE], by_search[FIND_TAG], by_search[FIND_DEPTH]);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(peeled).xy))) {
        return;
    }
    uvec4 near = next(pixel, 0u);
    uvec4 far = next(pixel, 1u);
    // Both reach the same layer: it is composited once. Past each other: none is left.
    bool apart = peel_before(near.xy, ~far.xy);
    near.w = uint(apart || near.xy == ~far.xy);
    far.w = uint(apart);
    imageStore(peeled, ivec3(pixel, 0), near);
    imageStore(peeled, ivec3(pixel, 1), far);
}
