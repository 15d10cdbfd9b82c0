// Compositing of sorted layers, one way for all techniques: equal layers give equal bits.
#include "transparency/layer.glsl"

// What was gathered from the front: radiance, and what is let through.
struct Gathered {
    vec3 rgb;
    vec3 through;
};

const Gathered NOTHING_GATHERED = Gathered(vec3(0.0), vec3(1.0));

// Puts a layer behind what is gathered so far (Porter and Duff 1984, *over*, channel by channel). Exact, so that equal
// layers give equal bits.
void put_behind(inout Gathered front, Layer layer) {
    precise vec3 rgb = front.rgb + front.through * layer.rgb;
    precise vec3 through = front.through * layer.through;
    front = Gathered(rgb, through);
}

// The same where all layers let the channels through alike: the alpha of `front` is what it lets through.
void put_behind(inout vec4 front, vec4 layer) {
    precise vec3 rgb = front.rgb + front.a * layer.rgb;
    precise float through = front.a * (1.0 - layer.a);
    front = vec4(rgb, through);
}

// The whole over what is opaque. Alpha goes by the channels' mean.
vec4 over_opaque(Gathered front, vec4 opaque) {
    precise vec3 rgb = front.rgb + front.through * opaque.rgb;
    precise float alpha = 1.0 - mean_of(front.through) * (1.0 - opaque.a);
    return vec4(rgb, alpha);
}

vec4 over_opaque(vec4 front, vec4 opaque) {
    return over_opaque(Gathered(front.rgb, vec3(front.a)), opaque);
}
