#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/depth.glsl"
#include "common/views.glsl"
#include "common/lights.glsl"
#include "common/brdf.glsl"
#include "common/environment.glsl"

// Deferred shading: every light over the G-buffer, shadows from screen masks.

layout(local_size_x = 64) in;

// Whether a light has a deep shadow map: a software driver would fetch from none for each light.
layout(constant_id = 0) const bool DEEP_SHADOWS = false;

layout(set = 0, binding = 4) uniform texture2D albedo;
layout(set = 0, binding = 5) uniform texture2D normal;
layout(set = 0, binding = 6) uniform texture2D material;
layout(set = 0, binding = 7) uniform texture2D emissive;
layout(set = 0, binding = 8) uniform texture2D depth;
layout(set = 0, binding = 9) uniform texture2DArray masks;
layout(set = 0, binding = 13) uniform texture2DArray deep_masks; // what comes through blended surfaces
layout(set = 0, binding = 10) writeonly uniform image2D color; // cd/m², premultiplied
layout(set = 0, binding = 11) writeonly uniform image2D direct; // cd/m², of the lights alone

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(color)))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    if (d == DEPTH_CLEAR) {
        imageStore(color, pixel, vec4(0.0));
        imageStore(direct, pixel, vec4(0.0));
        return;
    }
    vec3 position = (views[0].world_from_view * vec4(view_position(0u, vec2(pixel) + 0.5, d), 1.0)).xyz;
    vec4 base = texelFetch(albedo, pixel, 0);
    vec4 m = texelFetch(material, pixel, 0);
    vec3 glow = texelFetch(emissive, pixel, 0).rgb;
    if (m.b > 0.5) {
        imageStore(color, pixel, vec4(base.rgb + glow, 1.0));
        imageStore(direct, pixel, vec4(0.0));
        return;
    }

    vec3 n = normalize(texelFetch(normal, pixel, 0).xyz);
    vec3 v = direction_to_eye(0u, position);
    Reflectance r = reflectance(base.rgb, m.g, m.r);
    vec3 lit = vec3(0.0);
    uint i = 0u;
    do { // a light that does not shine stands in where there is none
        vec3 l;
        vec3 illuminance;
        light_at(lights[i], position, l, illuminance);
        if (dot(n, l) <= 0.0 || illuminance == vec3(0.0)) {
            continue;
        }
        if (lights[i].mask >= 0) {
            illuminance *= texelFetch(masks, ivec3(pixel, lights[i].mask), 0).r;
        }
        if (DEEP_SHADOWS && lights[i].deep >= 0) {
            illuminance *= texelFetch(deep_masks, ivec3(pixel, lights[i].deep), 0).rgb;
        }
        lit += illuminance * brdf_cosine(r, n, v, l);
    } while (++i < light_count);
    vec3 ambient = environment_reflection(r, base.a, abs(dot(n, v)));
    imageStore(direct, pixel, vec4(lit, 1.0));
    imageStore(color, pixel, vec4(lit + ambient + glow, 1.0));
}
