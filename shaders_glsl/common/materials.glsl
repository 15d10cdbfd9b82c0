// A glTF 2.0 metallic-roughness material: set 1 holds its factors and its textures, with white (or a flat normal)
// where it has none.

// Which textures a pipeline samples, as bits: a software driver runs both sides of every branch, so a texture that a
// material does not have is left out when the pipeline is made.
layout(constant_id = 0) const uint TEXTURES = 63u;

const uint TEXTURE_BASE_COLOR = 0u;
const uint TEXTURE_METALLIC_ROUGHNESS = 1u;
const uint TEXTURE_NORMAL = 2u;
const uint TEXTURE_OCCLUSION = 3u;
const uint TEXTURE_EMISSIVE = 4u;
const uint TEXTURE_TRANSMISSION = 5u;

// Bit k + 8 of `flags`: texture k uses the second texture coordinates.
const uint MATERIAL_UNLIT = 1u << 16;
const uint MATERIAL_PREMULTIPLIED = 1u << 17; // base colour is multiplied by alpha
const uint MATERIAL_ADD = 1u << 18; // hides nothing
const uint MATERIAL_OPAQUE = 1u << 19; // alpha has no meaning

layout(set = 1, binding = 5, scalar) uniform Material {
    vec4 base_color;
    vec3 emissive; // cd/m²
    float metallic;
    float roughness;
    float normal_scale;
    float occlusion_strength;
    float alpha_cutoff;
    vec3 uv_rows[12]; // two rows a texture, applied to (u, v, 1)
    uint flags;
    float transmission;
} material;

layout(set = 1, binding = 0) uniform sampler2D base_color_texture;
layout(set = 1, binding = 1) uniform sampler2D metallic_roughness_texture;
layout(set = 1, binding = 2) uniform sampler2D normal_texture;
layout(set = 1, binding = 3) uniform sampler2D occlusion_texture;
layout(set = 1, binding = 4) uniform sampler2D emissive_texture;
layout(set = 1, binding = 6) uniform sampler2D transmission_texture;

bool has_texture(uint slot) {
    return (TEXTURES & (1u << slot)) != 0u;
}

vec2 texture_coordinates(uint slot, vec2 uv0, vec2 uv1) {
    vec3 uv = vec3((material.flags & (256u << slot)) != 0u ? uv1 : uv0, 1.0);
    return vec2(dot(material.uv_rows[2u * slot], uv), dot(material.uv_rows[2u * slot + 1u], uv));
}

vec4 material_base_color(vec2 uv0, vec2 uv1, vec4 color) {
    vec4 base = material.base_color * color;
    if (has_texture(TEXTURE_BASE_COLOR)) {
        base *= texture(base_color_texture, texture_coordinates(TEXTURE_BASE_COLOR, uv0, uv1));
    }
    return base;
}
