#version 460
#extension GL_EXT_samplerless_texture_functions : require

// Puts what was gathered over the opaque picture, where there is a layer.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 3) const bool BOTH_ENDS = false; // layers from the back are over the picture already

layout(set = 0, binding = 0) uniform texture2D counts;
layout(set = 0, binding = 5, rgba32f) uniform image2D color; // premultiplied
layout(set = 0, binding = 24, rgba32f) readonly uniform image2DArray front;
#include "transparency/gathered.glsl"

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color))) || texelFetch(counts, pixel, 0).r == 0.0) {
        return;
    }
    Gathered gathered = load_gathered(pixel);
    vec4 behind = imageLoad(color, pixel);
    if (TINTED && BOTH_ENDS) {
        // To what both let through, the alpha of the opaque picture.
        vec3 back = imageLoad(front, ivec3(pixel, THROUGH_BACK)).rgb;
        float alpha = over_opaque(Gathered(vec3(0.0), gathered.through * back), behind).a;
        imageStore(color, pixel, vec4(over_opaque(gathered, behind).rgb, alpha));
    } else {
        imageStore(color, pixel, over_opaque(gathered, behind));
    }
}
