// Punctual lights: KHR_lights_punctual, sections "Light types" and "Inner and outer cone angles".

const uint LIGHT_DIRECTIONAL = 0u;
const uint LIGHT_POINT = 1u;
const uint LIGHT_SPOT = 2u;

struct Light {
    vec3 color; // linear Rec. 709 times lux (directional) or candela
    uint kind;
    vec3 position;
    float inverse_range; // 1/m, 0 without a range
    vec3 direction; // the way light travels
    float cone_scale;
    float cone_offset;
    int mask; // layer of the shadow masks, -1 without a shadow
    int shadow; // index among the lights its shadow technique serves, -1 without a shadow
    int deep; // index among the lights with a deep shadow map, -1 without
};

const uint MAX_LIGHTS = 256u;

layout(set = 0, binding = 3, scalar) uniform Lights {
    uint light_count;
    Light lights[MAX_LIGHTS];
};

// Way to the light (unit length), and illuminance on a plane facing it, in lux.
void light_at(Light light, vec3 position, out vec3 to_light, out vec3 illuminance) {
    if (light.kind == LIGHT_DIRECTIONAL) {
        to_light = -light.direction;
        illuminance = light.color;
        return;
    }
    vec3 offset = light.position - position;
    float squared = max(dot(offset, offset), 1e-12);
    to_light = offset * inversesqrt(squared);
    float ratio = squared * light.inverse_range * light.inverse_range;
    float attenuation = clamp(1.0 - ratio * ratio, 0.0, 1.0) / squared;
    if (light.kind == LIGHT_SPOT) {
        float cone = clamp(dot(light.direction, -to_light) * light.cone_scale + light.cone_offset, 0.0, 1.0);
        attenuation *= cone * cone;
    }
    illuminance = light.color * attenuation;
}
