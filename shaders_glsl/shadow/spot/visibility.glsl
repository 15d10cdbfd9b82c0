// Visibility of spot lights through one shadow map each, all layers of one array. Include after
// common/shadow_map.glsl.

layout(constant_id = 2) const uint SPOT_TAPS = 1u; // bilinear taps a side

const uint MAX_SPOTS = 64u;

struct SpotMap {
    mat4 clip_from_world; // the light's view
    vec3 position;
    float texel; // metres at a distance of one metre along the axis
    vec3 direction; // the way light travels
};

layout(set = 0, binding = 15, scalar) uniform SpotMaps {
    uint spot_count;
    float spot_map_texel; // 1 / resolution
    SpotMap spots[MAX_SPOTS];
};
layout(set = 0, binding = 16) uniform sampler2DArrayShadow spot_map;

float spot_visibility(uint index, vec3 position, vec3 normal) {
    SpotMap spot = spots[index];
    vec3 offset = spot.position - position;
    vec3 to_light = normalize(offset);
    if (dot(normal, to_light) <= 0.0) {
        return 0.0;
    }
    float distance_along_axis = dot(-offset, spot.direction);
    if (distance_along_axis <= 0.0) {
        return 1.0; // behind the light: its cone leaves it dark anyway
    }
    float texel = spot.texel * distance_along_axis;
    vec3 lifted = lift_receiver(position, normal, to_light, spot.direction, texel, SPOT_TAPS);
    vec4 clip = spot.clip_from_world * vec4(lifted, 1.0);
    vec3 ndc = clip.xyz / clip.w;
    if (any(greaterThan(abs(ndc.xy), vec2(1.0)))) {
        return 1.0;
    }
    return percentage_closer(spot_map, vec3(ndc.xy * 0.5 + 0.5, float(index)), ndc.z, SPOT_TAPS, spot_map_texel);
}
