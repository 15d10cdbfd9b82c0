// Visibility of a directional light through cascaded shadow maps. Include after common/shadow_map.glsl.

layout(constant_id = 1) const uint CASCADE_TAPS = 1u; // bilinear taps a side

const uint MAX_CASCADES = 8u;

struct Cascade {
    vec3 scale; // from light space to the map's texture coordinates and depth
    vec3 offset;
    float texel; // metres
    float end; // distance along the view axis, metres; infinite where there is no cascade
    float fade; // from here to `end` the next cascade is blended in
};

layout(set = 0, binding = 13, scalar) uniform Cascades {
    vec3 light_from_world[3]; // rows; the last is the way to the light
    uint cascade_count;
    float map_texel; // 1 / resolution
    Cascade cascades[MAX_CASCADES];
};
layout(set = 0, binding = 14) uniform sampler2DArrayShadow cascade_map;

// Looks at all of them: a software driver fetches at an index of each pixel's own pixel by pixel.
Cascade cascade_at(uint index) {
    Cascade cascade = cascades[0];
    for (uint i = 1u; i < MAX_CASCADES; ++i) {
        if (i == index) {
            cascade = cascades[i];
        }
    }
    return cascade;
}

float cascade_visibility(Cascade cascade, uint index, vec3 position, vec3 normal) {
    vec3 to_light = light_from_world[2];
    vec3 p = lift_receiver(position, normal, to_light, to_light, cascade.texel, CASCADE_TAPS);
    vec3 in_light = vec3(dot(light_from_world[0], p), dot(light_from_world[1], p), dot(light_from_world[2], p));
    vec3 in_map = in_light * cascade.scale + cascade.offset;
    return percentage_closer(cascade_map, vec3(in_map.xy, float(index)), in_map.z, CASCADE_TAPS, map_texel);
}

// `view_distance` is the distance along the view axis. `index` is the cascade, or cascade_count beyond the last.
float cascaded_visibility(vec3 position, vec3 normal, float view_distance, out uint index) {
    index = 0u;
    for (uint i = 0u; i < MAX_CASCADES; ++i) {
        index += uint(view_distance > cascades[i].end);
    }
    // A loop and not a branch: a software driver leaves a loop that no pixel of a vector needs, but runs both sides of
    // every branch. Few pixels look at a second cascade.
    float visibility = 0.0;
    float weight = 1.0;
    uint i = min(index, cascade_count - 1u);
    bool again;
    do {
        Cascade cascade = cascade_at(i);
        bool fades = i == index && i + 1u < cascade_count;
        float length = max(cascade.end - cascade.fade, 1e-30);
        float share = fades ? clamp((view_distance - cascade.fade) / length, 0.0, 1.0) : 0.0;
        visibility += weight * (1.0 - share) * cascade_visibility(cascade, i, position, normal);
        weight *= share;
        again = share > 0.0;
        ++i;
    } while (again);
    if (dot(normal, light_from_world[2]) <= 0.0) {
        return 0.0;
    }
    return index == cascade_count ? 1.0 : visibility;
}
