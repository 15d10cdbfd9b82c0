// Composites each pixel's layer of this round and finds the next (Everitt 2001, "Interactive order-independent
// transparency"). A fragment shader that includes this tests depth early.
#include "transparency/peeling.glsl"

layout(early_fragment_tests) in;

// Read only, but not declared so: then validation follows the order also where nothing is drawn in between.
layout(set = 0, binding = 22, rgba32ui) uniform uimage2D peeled; // state
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray found; // a layer a search
layout(set = 0, binding = 24, rgba32f) uniform image2DArray front;
#include "transparency/gathered.glsl"
#include "transparency/gather.glsl"

void peel(Layer layer, uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 state = imageLoad(peeled, pixel);
    uvec2 place = peel_place(gl_FragCoord.z, key);
    // One fragment of a pixel at most: nobody else touches it.
    if (place == state.xy) {
        gather(pixel, layer);
    }
    uint value;
    uint search = peel_search(state, place, value);
    if (search != FIND_NOTHING) {
        imageAtomicMax(found, ivec3(pixel, search), value);
    }
}
