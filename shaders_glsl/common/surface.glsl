// What a material says of one point of a surface.
#include "common/materials.glsl"

struct Surface {
    vec3 albedo; // linear base colour
    float alpha;
    vec3 normal; // world, unit length, on the viewer's side
    float roughness; // perceptual
    float metallic;
    float occlusion; // 1 is open
    vec3 emissive; // cd/m²
    float transmission;
    bool unlit;
};

Surface material_surface(vec2 uv0, vec2 uv1, vec4 color, vec3 normal, vec4 tangent, bool front) {
    Surface surface;
    vec4 base = material_base_color(uv0, uv1, color);
    surface.albedo = base.rgb;
    surface.alpha = (material.flags & MATERIAL_OPAQUE) != 0u ? 1.0 : base.a;
    surface.unlit = (material.flags & MATERIAL_UNLIT) != 0u;

    surface.roughness = material.roughness;
    surface.metallic = material.metallic;
    if (has_texture(TEXTURE_METALLIC_ROUGHNESS)) {
        vec2 uv = texture_coordinates(TEXTURE_METALLIC_ROUGHNESS, uv0, uv1);
        vec4 texel = texture(metallic_roughness_texture, uv);
        surface.roughness *= texel.g;
        surface.metallic *= texel.b;
    }

    // A zero normal (singular transform, degenerate input) stays finite.
    vec3 n = normal * inversesqrt(max(dot(normal, normal), 1e-30));
    if (has_texture(TEXTURE_NORMAL)) {
        vec2 uv = texture_coordinates(TEXTURE_NORMAL, uv0, uv1);
        vec3 texel = texture(normal_texture, uv).xyz * 2.0 - 1.0;
        vec3 t = tangent.xyz * inversesqrt(max(dot(tangent.xyz, tangent.xyz), 1e-30));
        vec3 b = cross(n, t) * tangent.w;
        n = t * (texel.x * material.normal_scale) + b * (texel.y * material.normal_scale) + n * texel.z;
        n *= inversesqrt(max(dot(n, n), 1e-30));
    }
    surface.normal = front ? n : -n;

    surface.occlusion = 1.0;
    if (has_texture(TEXTURE_OCCLUSION)) {
        vec2 uv = texture_coordinates(TEXTURE_OCCLUSION, uv0, uv1);
        surface.occlusion += material.occlusion_strength * (texture(occlusion_texture, uv).r - 1.0);
    }

    surface.emissive = material.emissive;
    if (has_texture(TEXTURE_EMISSIVE)) {
        vec2 uv = texture_coordinates(TEXTURE_EMISSIVE, uv0, uv1);
        surface.emissive *= texture(emissive_texture, uv).rgb;
    }

    surface.transmission = material.transmission;
    if (has_texture(TEXTURE_TRANSMISSION)) {
        vec2 uv = texture_coordinates(TEXTURE_TRANSMISSION, uv0, uv1);
        surface.transmission *= texture(transmission_texture, uv).r;
    }
    return surface;
}
