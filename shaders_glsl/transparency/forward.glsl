// Forward shading of BLEND materials: what every technique of this family composites.
#include "common/surface_fragment.glsl"
#include "common/lights.glsl"
#include "common/brdf.glsl"
#include "common/environment.glsl"
#include "common/shadow_map.glsl"
#include "shadow/cascaded/visibility.glsl"
#include "shadow/deep/visibility.glsl"
#include "shadow/spot/visibility.glsl"
#include "transparency/layer.glsl"
#include "transparency/passing.glsl"

// Whether a light has a deep shadow map: what is not there is not compiled.
layout(constant_id = 8) const bool DEEP_SHADOWS = false;

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

// Of a lit surface, towards the viewer; alpha is left out.
vec3 forward_radiance(Surface surface, float transmission) {
    vec3 n = surface.normal;
    vec3 v = direction_to_eye(0u, vertex_position);
    float view_distance = -(views[0].view_from_world * vec4(vertex_position, 1.0)).z;
    Reflectance r = reflectance(surface.albedo, surface.metallic, surface.roughness);
    r.diffuse *= 1.0 - transmission;
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
        if (DEEP_SHADOWS && lights[i].deep >= 0) {
            illuminance *= deep_visibility(uint(lights[i].deep), vertex_position, n);
        }
        lit += illuminance * brdf_cosine(r, n, v, l);
    } while (++i < light_count);
    return lit + environment_reflection(r, surface.occlusion, abs(dot(n, v))) + surface.emissive;
}

Layer forward_layer() {
    Surface surface = fragment_surface();
    float transmission = TINTED ? surface.transmission : 0.0;
    vec3 radiance;
    if (surface.unlit) {
        radiance = surface.albedo * (1.0 - transmission) + surface.emissive;
    } else {
        radiance = forward_radiance(surface, transmission);
    }
    // Premultiplied materials have their alpha in the base colour.
    bool premultiplied = (material.flags & MATERIAL_PREMULTIPLIED) != 0u;
    vec3 rgb = premultiplied ? radiance : radiance * surface.alpha;
    if (TINTED && transmission > 0.0) {
        return tinted_layer(rgb, passing(surface, direction_to_eye(0u, vertex_position)));
    }
    return plain_layer(vec4(rgb, (material.flags & MATERIAL_ADD) != 0u ? 0.0 : surface.alpha));
}

// Radiance, premultiplied, and alpha.
vec4 forward_color() {
    Layer layer = forward_layer();
    return vec4(layer.rgb, layer.alpha);
}
