// What comes through blended surfaces to a point, of each light that has a deep shadow map (Lokovic and Veach 2000, "Deep
// shadow maps"). Include after common/shadow_map.glsl.

const uint MAX_DEEP_MAPS = 8u;
// Steps of a row of `deep_steps`.
const uint DEEP_ROW = 4096u;

struct DeepMap {
    mat4 clip_from_world; // the light's view
    vec4 eye; // w 1: position; w 0: direction to the light
    vec3 axis; // the way light travels
    float texel; // metres; of a spot, at a distance of one metre along the axis
};

layout(set = 0, binding = 27, scalar) uniform DeepMaps {
    uint deep_count;
    uint deep_resolution;
    DeepMap deep_maps[MAX_DEEP_MAPS]; // side by side
};
layout(set = 0, binding = 28) uniform sampler2D deep_spans; // by texel: first step, how many, nearest, farthest depth
layout(set = 0, binding = 29) uniform usampler2D deep_steps; // bits of floats: depth, and what comes through behind it

vec4 deep_step(uint at) {
    return uintBitsToFloat(texelFetch(deep_steps, ivec2(at % DEEP_ROW, at / DEEP_ROW), 0));
}

// The function of a texel. Depth is reversed: a step before a point has the larger one.
vec3 deep_transmittance(ivec2 texel, float depth) {
    vec4 span = texelFetch(deep_spans, texel, 0);
    uint first = uint(span.x);
    uint behind = uint(span.y); // steps before this one are before the point
    uint low = depth < span.w ? behind : 0u;
    behind = depth < span.z ? behind : 0u;
    while (low < behind) {
        uint middle = (low + behind) / 2u;
        uint at = first + middle;
        bool before = deep_step(at).x > depth;
        low = before ? middle + 1u : low;
        behind = before ? behind : middle;
    }
    uint last = first + max(low, 1u) - 1u;
    vec3 through = deep_step(last).yzw;
    return low > 0u ? through : vec3(1.0);
}

// Filtered bilinearly. `normal`: of the surface, on either side.
vec3 deep_visibility(uint index, vec3 position, vec3 normal) {
    DeepMap map = deep_maps[index];
    vec3 offset = map.eye.xyz - map.eye.w * position;
    vec3 to_light = normalize(offset);
    float along_axis = map.eye.w > 0.0 ? dot(-offset, map.axis) : 1.0;
    if (along_axis <= 0.0) {
        return vec3(1.0); // behind the light
    }
    vec3 towards = dot(normal, to_light) < 0.0 ? -normal : normal;
    vec3 lifted = lift_receiver(position, towards, to_light, map.axis, map.texel * along_axis, 1u);
    vec4 clip = map.clip_from_world * vec4(lifted, 1.0);
    vec3 ndc = clip.xyz / clip.w;
    if (any(greaterThan(abs(ndc.xy), vec2(1.0)))) {
        return vec3(1.0);
    }
    vec2 texel = (ndc.xy * 0.5 + 0.5) * float(deep_resolution) - 0.5;
    ivec2 low = ivec2(floor(texel));
    vec2 share = texel - vec2(low);
    vec3 sum = vec3(0.0);
    for (int corner = 0; corner < 4; ++corner) {
        ivec2 of = ivec2(corner & 1, corner >> 1);
        vec2 weight = mix(1.0 - share, share, vec2(of));
        ivec2 at = clamp(low + of, ivec2(0), ivec2(deep_resolution) - 1);
        at.x += int(index * deep_resolution);
        sum += weight.x * weight.y * deep_transmittance(at, ndc.z);
    }
    return sum;
}
