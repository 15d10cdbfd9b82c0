#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/depth.glsl"
#include "common/views.glsl"
#include "common/normals.glsl"
#include "common/shadow_map.glsl"
#include "shadow/cascaded/visibility.glsl"

layout(local_size_x = 64) in;

layout(set = 0, binding = 4) uniform texture2D depth;
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, r32f) writeonly uniform image2D mask; // 1 is lit
layout(set = 0, binding = 7, r32f) writeonly uniform image2D cascade_index; // from 1; 0 is background or beyond

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(mask)))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    float visibility = 1.0;
    uint cascade = cascade_count;
    if (d != DEPTH_CLEAR) {
        vec3 p = view_position(0u, vec2(pixel) + 0.5, d);
        vec3 world = (views[0].world_from_view * vec4(p, 1.0)).xyz;
        vec3 normal = unpack_normal(texelFetch(ids, pixel, 0).w);
        visibility = cascaded_visibility(world, normal, -p.z, cascade);
    }
    imageStore(mask, pixel, vec4(visibility));
    imageStore(cascade_index, pixel, vec4(cascade == cascade_count ? 0.0 : float(cascade + 1u)));
}
