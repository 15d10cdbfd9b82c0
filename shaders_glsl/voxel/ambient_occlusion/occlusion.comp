#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_samplerless_texture_functions : require
#include "voxel/visibility.glsl"
#include "common/normals.glsl"

// The share of a cosine-weighted hemisphere that nothing nearby blocks, by rays through voxels.

layout(local_size_x = 8, local_size_y = 8) in;

layout(constant_id = 0) const uint RAYS = 32u;

layout(push_constant, scalar) uniform OcclusionPush {
    float offset; // metres off the surface where rays begin
    float reach; // metres
};
layout(set = 0, binding = 4) uniform texture2D position; // a: distance, infinite in the background
layout(set = 0, binding = 5) uniform utexture2D ids;
layout(set = 0, binding = 6, r32f) writeonly uniform image2D open; // 1: nothing nearby

// Jimenez 2014, "Next generation post processing in Call of Duty: Advanced Warfare": interleaved gradient noise.
float turn_of(vec2 pixel) {
    return fract(52.9829189 * fract(dot(pixel, vec2(0.06711056, 0.00583715))));
}

// Duff et al. 2017, "Building an orthonormal basis, revisited".
mat3 around(vec3 n) {
    float s = n.z >= 0.0 ? 1.0 : -1.0;
    float a = -1.0 / (s + n.z);
    float b = n.x * n.y * a;
    return mat3(vec3(1.0 + s * n.x * n.x * a, s * b, -s * n.x), vec3(b, s + n.y * n.y * a, -n.y), n);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    if (any(greaterThanEqual(pixel, imageSize(open)))) {
        return;
    }
    vec4 place = texelFetch(position, pixel, 0);
    if (isinf(place.w)) {
        imageStore(open, pixel, vec4(1.0));
        return;
    }
    vec3 normal = unpack_normal(texelFetch(ids, pixel, 0).w);
    mat3 frame = around(normal);
    vec3 origin = place.xyz + offset * normal;
    float turn = turn_of(vec2(pixel));
    uint blocked = 0u;
    for (uint i = 0u; i < RAYS; ++i) {
        // Hammersley's points, turned by the pixel's own angle; uniform on the disc is cosine-weighted above it (Malley).
        float square = (float(i) + 0.5) / float(RAYS);
        float angle = 6.28318531 * fract(float(bitfieldReverse(i)) * 2.3283064365386963e-10 + turn);
        vec3 direction = vec3(sqrt(square) * vec2(cos(angle), sin(angle)), sqrt(1.0 - square));
        blocked += uint(is_blocked(origin, origin + reach * (frame * direction)));
    }
    imageStore(open, pixel, vec4(1.0 - float(blocked) / float(RAYS)));
}
