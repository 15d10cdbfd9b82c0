// What passes straight through a BLEND or transmissive surface, channel by channel. Include after
// common/surface_fragment.glsl.

// Of light along `direction` (unit length, either way). KHR_materials_transmission for a thin and smooth surface: what
// Schlick's Fresnel term of a dielectric does not reflect is multiplied by the base colour; metals let nothing through.
vec3 passing(Surface surface, vec3 direction) {
    if ((material.flags & MATERIAL_ADD) != 0u) {
        return vec3(1.0);
    }
    vec3 entering = surface.albedo * surface.transmission;
    if (!surface.unlit) {
        float m = 1.0 - min(abs(dot(surface.normal, direction)), 1.0);
        float m2 = m * m;
        entering *= (1.0 - surface.metallic) * (1.0 - 0.04) * (1.0 - m2 * m2 * m);
    }
    return 1.0 - surface.alpha * (1.0 - entering);
}
