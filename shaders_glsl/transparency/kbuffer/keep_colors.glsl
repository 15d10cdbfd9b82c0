// Stores the colours of the layers that are kept, and sums up the others.
#include "transparency/layer.glsl"
#include "transparency/sums.glsl"

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint KEPT = 4u;

layout(set = 0, binding = 22, r32ui) readonly uniform uimage2DArray kept_depths;
layout(set = 0, binding = 23, r32ui) readonly uniform uimage2DArray kept_tags; // numbers plus 1
// A layer each; where they tint, what they let through in as many more.
layout(set = 0, binding = 24, rgba32f) writeonly uniform image2DArray kept_colors;

void keep_color(Layer layer, uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uvec2 own = uvec2(floatBitsToUint(gl_FragCoord.z), key + 1u);
    vec4 color = vec4(layer.rgb, layer.alpha);
    bool kept = false;
    for (uint place = 0u; place < KEPT; ++place) {
        ivec3 at = ivec3(pixel, place);
        if (own == uvec2(imageLoad(kept_depths, at).r, imageLoad(kept_tags, at).r)) {
            imageStore(kept_colors, at, color);
            if (TINTED) {
                imageStore(kept_colors, at + ivec3(0, 0, KEPT), vec4(layer.through, 0.0));
            }
            kept = true;
        }
    }
    add_layer(kept ? vec4(0.0) : color, 1.0);
}
