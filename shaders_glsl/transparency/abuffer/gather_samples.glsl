// Compositing of a pixel's samples. What lies behind all nodes is the same for all of them, so their colours are only summed
// up, and each keeps no more than what it lets through.
#include "transparency/abuffer/samples.glsl"

struct GatheredSamples {
    vec3 rgb; // mean of the samples
    vec3 through[MOST_SAMPLES];
};

GatheredSamples nothing_gathered() {
    GatheredSamples front;
    front.rgb = vec3(0.0);
    for (uint i = 0u; i < SAMPLES; i++) {
        front.through[i] = vec3(1.0);
    }
    return front;
}

// In pairs: exact where all are equal.
vec3 mean_of_samples(vec3 through[MOST_SAMPLES]) {
    for (uint half_of = SAMPLES / 2u; half_of > 0u; half_of /= 2u) {
        for (uint i = 0u; i < half_of; i++) {
            precise vec3 sum = through[i] + through[i + half_of];
            through[i] = sum;
        }
    }
    return through[0] * (1.0 / float(SAMPLES));
}

bool is_opaque(GatheredSamples front) {
    bool opaque = true;
    for (uint i = 0u; i < SAMPLES; i++) {
        opaque = opaque && all(equal(front.through[i], vec3(0.0)));
    }
    return opaque;
}

// Puts a layer behind what is gathered so far, at the samples that it is seen at.
void put_behind(inout GatheredSamples front, Layer layer, uint samples) {
    vec3 reaching[MOST_SAMPLES];
    for (uint i = 0u; i < SAMPLES; i++) {
        bool seen = SAMPLES == 1u || (samples >> i & 1u) != 0u;
        precise vec3 through = front.through[i] * layer.through;
        reaching[i] = seen ? front.through[i] : vec3(0.0);
        front.through[i] = seen ? through : front.through[i];
    }
    precise vec3 rgb = front.rgb + mean_of_samples(reaching) * layer.rgb;
    front.rgb = rgb;
}

vec4 over_opaque(GatheredSamples front, vec4 opaque) {
    return over_opaque(Gathered(front.rgb, mean_of_samples(front.through)), opaque);
}
