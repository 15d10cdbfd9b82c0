#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "common/views.glsl"
#include "common/depth.glsl"

// World-space position and distance along the view axis, from depth.

layout(local_size_x = 64) in;

layout(set = 0, binding = 4) uniform texture2D depth;
layout(set = 0, binding = 5) writeonly uniform image2D position; // a: distance, metres

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(position)))) {
        return;
    }
    float d = texelFetch(depth, pixel, 0).r;
    if (d == DEPTH_CLEAR) {
        imageStore(position, pixel, vec4(0.0, 0.0, 0.0, uintBitsToFloat(0x7f800000u)));
        return;
    }
    vec3 p = view_position(0u, vec2(pixel) + 0.5, d);
    imageStore(position, pixel, vec4((views[0].world_from_view * vec4(p, 1.0)).xyz, -p.z));
}
