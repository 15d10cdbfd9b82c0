#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/depth.glsl"
#include "common/views.glsl"
#include "common/normals.glsl"
#include "common/shadow_map.glsl"
#include "shadow/spot/visibility.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 4) uniform texture2D depth;
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, r32f) writeonly uniform image2DArray masks; // a layer a light; 1 is lit

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(masks).xy))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    vec3 p = view_position(0u, vec2(pixel) + 0.5, d);
    vec3 world = (views[0].world_from_view * vec4(p, 1.0)).xyz;
    vec3 normal = unpack_normal(texelFetch(ids, pixel, 0).w);
    uint spot = 0u;
    do {
        float visibility = d == DEPTH_CLEAR ? 1.0 : spot_visibility(spot, world, normal);
        imageStore(masks, ivec3(pixel, spot), vec4(visibility));
    } while (++spot < spot_count);
}
