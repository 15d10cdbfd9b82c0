// Compositing of a pixel's samples. What lies behind all nodes is the same for all of them, so their colours are only summed
// up, and each keeps no more than what it lets through.
#include "transparency/abuffer/samples.glsl"

#ifndef MULTISAMPLED
// Of one sample: nothing indexed, so that drivers keep it in registers and unroll the loops around it.
#define GatheredSamples Gathered

Gathered nothing_gathered() {
    return NOTHING_GATHERED;
}

bool is_opaque(Gathered front) {
    return all(equal(front.through, vec3(0.0)));
}

void put_behind(inout Gathered front, Layer layer, uint samples) {
    put_behind(front, layer);
}
#else
// Samples are components, and none of this is a loop: drivers unroll the loops around it, and keep it all in registers.
struct GatheredSamples {
    vec3 rgb; // mean of the samples
    // What each lets through: columns are red, green and blue; of samples that there are not, 0.
    mat3x4 first; // samples 0 to 3
    mat3x4 last; // 4 to 7
};

GatheredSamples nothing_gathered() {
    vec4 first = vec4(lessThan(uvec4(0u, 1u, 2u, 3u), uvec4(SAMPLES)));
    vec4 last = vec4(SAMPLES > 4u ? 1.0 : 0.0);
    return GatheredSamples(vec3(0.0), mat3x4(first, first, first), mat3x4(last, last, last));
}

// In pairs: exact where all are equal.
float mean_of_samples(vec4 first, vec4 last) {
    precise vec4 fours = SAMPLES > 4u ? first + last : first;
    precise vec2 pairs = SAMPLES > 2u ? fours.xy + fours.zw : fours.xy;
    precise float sum = pairs.x + pairs.y;
    return sum * (1.0 / float(SAMPLES));
}

bool is_opaque(GatheredSamples front) {
    return front.first == mat3x4(0.0) && front.last == mat3x4(0.0);
}

// Puts one channel of a layer behind at the samples that it is seen at, and says how much of it the mean shows.
float put_behind(inout vec4 first, inout vec4 last, float through, bvec4 seen_first, bvec4 seen_last) {
    float reaching = mean_of_samples(mix(vec4(0.0), first, seen_first), mix(vec4(0.0), last, seen_last));
    precise vec4 behind_first = first * through;
    precise vec4 behind_last = last * through;
    first = mix(first, behind_first, seen_first);
    last = mix(last, behind_last, seen_last);
    return reaching;
}

// Puts a layer behind what is gathered so far, at the samples that it is seen at.
void put_behind(inout GatheredSamples front, Layer layer, uint samples) {
    bvec4 seen_first = notEqual(uvec4(samples) & uvec4(1u, 2u, 4u, 8u), uvec4(0u));
    bvec4 seen_last = notEqual(uvec4(samples) & uvec4(16u, 32u, 64u, 128u), uvec4(0u));
    vec3 reaching = vec3(
        put_behind(front.first[0], front.last[0], layer.through.r, seen_first, seen_last),
        put_behind(front.first[1], front.last[1], layer.through.g, seen_first, seen_last),
        put_behind(front.first[2], front.last[2], layer.through.b, seen_first, seen_last)
    );
    precise vec3 rgb = front.rgb + reaching * layer.rgb;
    front.rgb = rgb;
}

vec4 over_opaque(GatheredSamples front, vec4 opaque) {
    vec3 through = vec3(
        mean_of_samples(front.first[0], front.last[0]),
        mean_of_samples(front.first[1], front.last[1]),
        mean_of_samples(front.first[2], front.last[2])
    );
    return over_opaque(Gathered(front.rgb, through), opaque);
}
#endif
