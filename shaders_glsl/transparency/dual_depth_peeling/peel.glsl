// Composites each pixel's nearest and farthest layer of this round and finds the next of both (Bavoil and Myers 2008,
// "Order independent transparency with dual depth peeling"). From the back everything is turned around: complements of
// depth and tag sort the other way. A fragment shader that includes this tests depth early.
#include "transparency/composite.glsl"
#include "transparency/peeling.glsl"

layout(early_fragment_tests) in;

// Read only, but not declared so: then validation follows the order also where nothing is drawn in between.
layout(set = 0, binding = 22, rgba32ui) uniform uimage2DArray peeled; // states from the front, from the back
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray found; // a layer a search, from the front, from the back
layout(set = 0, binding = 24, rgba32f) uniform image2D front;
layout(set = 0, binding = 25, rgba32f) uniform image2D back; // begins as what is opaque

void peel(vec4 color, uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 near = imageLoad(peeled, ivec3(pixel, 0));
    uvec4 far = imageLoad(peeled, ivec3(pixel, 1));
    uvec2 place = peel_place(gl_FragCoord.z, key);
    // One fragment of a pixel at most in each: nobody else touches it.
    if (place == near.xy && near.w > 0u) {
        vec4 gathered = imageLoad(front, pixel);
        put_behind(gathered, color);
        imageStore(front, pixel, gathered);
    } else if (~place == far.xy && far.w > 0u) {
        vec4 behind = imageLoad(back, pixel);
        imageStore(back, pixel, color + (1.0 - color.a) * behind);
    }
    // What is left lies between both.
    if (!peel_before(near.xy, place) || !peel_before(far.xy, ~place)) {
        return;
    }
    uint value;
    uint search = peel_search(near, place, value);
    if (search != FIND_NOTHING) {
        imageAtomicMax(found, ivec3(pixel, search), value);
    }
    search = peel_search(far, ~place, value);
    if (search != FIND_NOTHING) {
        imageAtomicMax(found, ivec3(pixel, SEARCHES + search), value);
    }
}
