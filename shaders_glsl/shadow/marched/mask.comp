#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "voxel/visibility.glsl"
#include "common/normals.glsl"
#include "shadow/marched/visibility.glsl"

// What lights reach at each pixel, by a ray a light.

layout(local_size_x = 64) in;

layout(set = 0, binding = 4) uniform texture2D position; // a: distance, infinite in the background
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, r32f) writeonly uniform image2DArray masks; // a layer a light; 1 is lit

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(masks).xy))) {
        return;
    }
    vec4 place = texelFetch(position, pixel, 0);
    vec3 normal = unpack_normal(texelFetch(ids, pixel, 0).w);
    uint light = 0u;
    do {
        float visibility = isinf(place.w) ? 1.0 : marched_visibility(light, place.xyz, normal);
        imageStore(masks, ivec3(pixel, light), vec4(visibility));
    } while (++light < marched_count);
}
