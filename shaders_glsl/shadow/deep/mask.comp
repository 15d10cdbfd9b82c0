#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/depth.glsl"
#include "common/views.glsl"
#include "common/normals.glsl"
#include "common/shadow_map.glsl"
#include "shadow/deep/visibility.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 4) uniform texture2D depth;
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, rgba32f) writeonly uniform image2DArray masks; // a layer a light

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(masks).xy))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    vec3 p = view_position(0u, vec2(pixel) + 0.5, d);
    vec3 world = (views[0].world_from_view * vec4(p, 1.0)).xyz;
    vec3 normal = unpack_normal(texelFetch(ids, pixel, 0).w);
    for (uint light = 0u; light < deep_count; ++light) {
        vec3 through = d == DEPTH_CLEAR ? vec3(1.0) : deep_visibility(light, world, normal);
        imageStore(masks, ivec3(pixel, light), vec4(through, 1.0));
    }
}
