#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/depth.glsl"
#include "common/views.glsl"
#include "common/normals.glsl"
#include "common/shadow_map.glsl"
#include "shadow/spot/visibility.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(set = 0, binding = 4) uniform texture2D depth;
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, r32f) writeonly uniform image2D mask; // 1 is lit

layout(push_constant, scalar) uniform SpotPush {
    uint spot;
} push;

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(mask)))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    float visibility = 1.0;
    if (d != DEPTH_CLEAR) {
        vec3 p = view_position(0u, vec2(pixel) + 0.5, d);
        vec3 world = (views[0].world_from_view * vec4(p, 1.0)).xyz;
        visibility = spot_visibility(push.spot, world, unpack_normal(texelFetch(ids, pixel, 0).w));
    }
    imageStore(mask, pixel, vec4(visibility));
}
