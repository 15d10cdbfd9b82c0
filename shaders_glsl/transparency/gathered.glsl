// What was gathered from the front, in an image: radiance and what is let through; where layers tint, the latter channel by
// channel in a layer of its own, and behind it what the layers gathered from the back let through.
#include "transparency/composite.glsl"

const int THROUGH = 1;
const int THROUGH_BACK = 2;

Gathered load_gathered(ivec2 pixel) {
    vec4 gathered = imageLoad(front, ivec3(pixel, 0));
    return Gathered(gathered.rgb, TINTED ? imageLoad(front, ivec3(pixel, THROUGH)).rgb : vec3(gathered.a));
}
