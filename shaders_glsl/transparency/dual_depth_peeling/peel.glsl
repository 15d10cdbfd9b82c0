// Composites each pixel's nearest and farthest layer of this round and finds the next of both (Bavoil and Myers 2008,
// "Order independent transparency with dual depth peeling"). From the back everything is turned around: complements of
// depth and tag sort the other way. A fragment shader that includes this tests depth early.
#include "transparency/peeling.glsl"

layout(early_fragment_tests) in;

// Read only, but not declared so: then validation follows the order also where nothing is drawn in between.
layout(set = 0, binding = 22, rgba32ui) uniform uimage2DArray peeled; // states from the front, from the back
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray found; // a layer a search, from the front, from the back
layout(set = 0, binding = 24, rgba32f) uniform image2DArray front;
layout(set = 0, binding = 25, rgba32f) uniform image2D back; // begins as what is opaque
#include "transparency/gathered.glsl"
#include "transparency/gather.glsl"

void peel(Layer layer, uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec4 near = imageLoad(peeled, ivec3(pixel, 0));
    uvec4 far = imageLoad(peeled, ivec3(pixel, 1));
    uvec2 place = peel_place(gl_FragCoord.z, key);
    // One fragment of a pixel at most in each: nobody else touches it.
    if (place == near.xy && near.w > 0u) {
        gather(pixel, layer);
    } else if (~place == far.xy && far.w > 0u) {
        vec4 behind = imageLoad(back, pixel);
        vec3 rgb = layer.rgb + layer.through * behind.rgb;
        if (TINTED) {
            // Alpha goes by the mean of all that is let through: it is left to the end.
            imageStore(back, pixel, vec4(rgb, behind.a));
            vec3 through = imageLoad(front, ivec3(pixel, THROUGH_BACK)).rgb;
            imageStore(front, ivec3(pixel, THROUGH_BACK), vec4(layer.through * through, 0.0));
        } else {
            imageStore(back, pixel, vec4(rgb, layer.alpha + layer.through.r * behind.a));
        }
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
