// Visibility of a directional light through cascaded shadow maps. Include after common/shadow_map.glsl.

const uint MAX_CASCADES = 8u;

struct Cascade {
    mat4 clip_from_world; // the light's view of this cascade
    float texel; // metres
    float end; // distance along the view axis, metres
    float fade; // from here to `end` the next cascade is blended in
};

layout(set = 0, binding = 13, scalar) uniform Cascades {
    vec3 to_light;
    uint cascade_count;
    int taps;
    float map_texel; // 1 / resolution
    Cascade cascades[MAX_CASCADES];
};
layout(set = 0, binding = 14) uniform sampler2DArrayShadow cascade_map;

float cascade_visibility(uint index, vec3 position, vec3 normal) {
    vec3 lifted = lift_receiver(position, normal, to_light, to_light, cascades[index].texel, taps);
    vec4 clip = cascades[index].clip_from_world * vec4(lifted, 1.0);
    return percentage_closer(cascade_map, vec3(clip.xy * 0.5 + 0.5, float(index)), clip.z, taps, map_texel);
}

// `view_distance` is the distance along the view axis. `index` is the cascade, or cascade_count beyond the last.
float cascaded_visibility(vec3 position, vec3 normal, float view_distance, out uint index) {
    index = 0u;
    while (index < cascade_count && view_distance > cascades[index].end) {
        ++index;
    }
    if (dot(normal, to_light) <= 0.0) {
        return 0.0;
    }
    if (index == cascade_count) {
        return 1.0;
    }
    float visibility = cascade_visibility(index, position, normal);
    Cascade cascade = cascades[index];
    if (view_distance > cascade.fade && index + 1u < cascade_count) {
        float share = (view_distance - cascade.fade) / (cascade.end - cascade.fade);
        visibility = mix(visibility, cascade_visibility(index + 1u, position, normal), share);
    }
    return visibility;
}
