// A layer: what a surface adds to what lies behind it, and what of that it lets through.
#ifndef TRANSPARENCY_LAYER_GLSL
#define TRANSPARENCY_LAYER_GLSL

// Whether what passes through is multiplied channel by channel. Techniques that keep one alpha a layer show materials as
// they are without KHR_materials_transmission.
layout(constant_id = 7) const bool TINTED = false;

struct Layer {
    vec3 rgb; // radiance, premultiplied
    float alpha; // what it hides; of tinted layers the channels' mean
    vec3 through; // what it lets through, channel by channel
};

// The channels' mean, exact where they are equal.
float mean_of(vec3 through) {
    return through.g + ((through.r - through.g) + (through.b - through.g)) * (1.0 / 3.0);
}

// A layer that lets all channels through alike, from a premultiplied colour.
Layer plain_layer(vec4 color) {
    precise float through = 1.0 - color.a;
    return Layer(color.rgb, color.a, vec3(through));
}

Layer tinted_layer(vec3 rgb, vec3 through) {
    return Layer(rgb, 1.0 - mean_of(through), through);
}

#endif
