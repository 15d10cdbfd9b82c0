// Forward shading of BLEND materials: what every technique of this family composites.
#include "common/surface_fragment.glsl"
#include "common/lights.glsl"
#include "common/brdf.glsl"
#include "common/environment.glsl"
#include "common/shadow_map.glsl"
#include "shadow/cascaded/visibility.glsl"
#include "shadow/spot/visibility.glsl"

float light_visibility(Light light, vec3 position, vec3 normal, float view_distance) {
    if (light.shadow < 0) {
        return 1.0;
    }
    if (light.kind == LIGHT_DIRECTIONAL) {
        uint cascade;
        return cascaded_visibility(position, normal, view_distance, cascade);
    }
    return spot_visibility(uint(light.shadow), position, normal);
}

// Radiance, premultiplied, and alpha.
vec4 forward_color() {
    Surface surface = fragment_surface();
    if (surface.unlit) {
        return vec4((surface.albedo + surface.emissive) * surface.alpha, surface.alpha);
    }
    vec3 n = surface.normal;
    vec3 v = direction_to_eye(0u, vertex_position);
    float view_distance = -(views[0].view_from_world * vec4(vertex_position, 1.0)).z;
    Reflectance r = reflectance(surface.albedo, surface.metallic, surface.roughness);
    vec3 lit = vec3(0.0);
    uint i = 0u;
    do { // a light that does not shine stands in where there is none
        vec3 l;
        vec3 illuminance;
        light_at(lights[i], vertex_position, l, illuminance);
        if (dot(n, l) <= 0.0 || illuminance == vec3(0.0)) {
            continue;
        }
        illuminance *= light_visibility(lights[i], vertex_position, n, view_distance);
        lit += illuminance * brdf_cosine(r, n, v, l);
    } while (++i < light_count);
    lit += environment_reflection(r, surface.occlusion, abs(dot(n, v))) + surface.emissive;
    return vec4(lit * surface.alpha, surface.alpha);
}
