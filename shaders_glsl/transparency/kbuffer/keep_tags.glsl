// Finds which triangles have the kept depths: of equal depth the larger numbers, as far as there are places.

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint KEPT = 4u;

layout(set = 0, binding = 22, r32ui) readonly uniform uimage2DArray kept_depths;
layout(set = 0, binding = 23, r32ui) uniform uimage2DArray kept_tags; // numbers plus 1

void keep_tag(uint key) {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint depth = floatBitsToUint(gl_FragCoord.z);
    uint tag = key + 1u;
    for (uint place = 0u; place < KEPT && tag > 0u; ++place) {
        if (imageLoad(kept_depths, ivec3(pixel, place)).r == depth) {
            tag = min(tag, imageAtomicMax(kept_tags, ivec3(pixel, place), tag));
        }
    }
}
