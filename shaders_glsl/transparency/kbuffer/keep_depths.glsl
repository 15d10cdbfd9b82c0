// Finds the depths of each pixel's nearest layers: places sorted nearest first, 0 where there is no layer. A value that
// comes to a place leaves the larger one there and carries the smaller one on, so any order of fragments gives the same.

layout(early_fragment_tests) in;

layout(constant_id = 3) const uint KEPT = 4u;

layout(set = 0, binding = 22, r32ui) uniform uimage2DArray kept_depths;

void keep_depth() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    uint depth = floatBitsToUint(gl_FragCoord.z); // reversed and positive: its bits sort as it does
    if (depth <= imageLoad(kept_depths, ivec3(pixel, KEPT - 1u)).r) {
        return;
    }
    for (uint place = 0u; place < KEPT && depth > 0u; ++place) {
        depth = min(depth, imageAtomicMax(kept_depths, ivec3(pixel, place), depth));
    }
}
