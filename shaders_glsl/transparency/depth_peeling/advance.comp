#version 460
#include "transparency/peeling.glsl"

// From the layers that were just composited to those found behind them.

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 22, rgba32ui) uniform uimage2D peeled;
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray found;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(peeled)))) {
        return;
    }
    uint by_search[SEARCHES];
    for (uint search = 0u; search < SEARCHES; ++search) {
        by_search[search] = imageLoad(found, ivec3(pixel, search)).r;
        imageStore(found, ivec3(pixel, search), uvec4(0u));
    }
    uvec4 state = imageLoad(peeled, pixel);
    state = peel_next(state, by_search[FIND_TIE], by_search[FIND_TAG], by_search[FIND_DEPTH]);
    imageStore(peeled, pixel, state);
}
