// Visibility of lights through the voxels of a scene. Include after voxel/visibility.glsl.

const uint MAX_MARCHED_LIGHTS = 64u;

struct MarchedLight {
    vec3 place; // world space; where `is_near` is 0 the unit direction to the light
    float is_near;
};

layout(set = 0, binding = 15, scalar) uniform MarchedLights {
    uint marched_count;
    float marched_offset; // metres off the surface where rays begin
    float marched_reach; // metres to where a distant light's rays end
    MarchedLight marched_lights[MAX_MARCHED_LIGHTS];
};

float marched_visibility(uint index, vec3 position, vec3 normal) {
    MarchedLight light = marched_lights[index];
    bool is_near = light.is_near != 0.0;
    vec3 to_light = is_near ? light.place - position : light.place;
    if (dot(normal, to_light) <= 0.0) {
        return 0.0;
    }
    vec3 origin = position + marched_offset * normal;
    vec3 end = is_near ? light.place : origin + marched_reach * light.place;
    return is_blocked(origin, end) ? 0.0 : 1.0;
}
