#version 460
#extension GL_EXT_scalar_block_layout : require
#define PAIR_ACCESS readonly
#include "common/triangle_voxels.glsl"
#include "common/pulled_vertices.glsl"
#include "common/materials.glsl"
#include "voxel/attributes/sums.glsl"
#include "voxel/attributes/clip.glsl"
#include "voxel/attributes/pair_lists.glsl"

// A pair of triangle and voxel a pixel: adds what the triangle is like to the voxel's sums, by the area of its part there.
// A driver that runs pixels in vectors, one for each triangle and row of voxels, would leave most lanes of them idle.

layout(constant_id = 1) const bool EMITS = true; // anything in the scene

layout(push_constant, scalar) uniform AttributesPush {
    uint is_opaque; // alpha does not count
    uint first; // pair
    uint count; // of pairs
    uint width; // pixels side by side
};
layout(set = 0, binding = 8, scalar) buffer WeightSums {
    uint weight_sums[]; // weight, weight · alpha
};
layout(set = 0, binding = 9, scalar) buffer AlbedoSums {
    uint albedo_sums[];
};
layout(set = 0, binding = 10, scalar) buffer NormalSums {
    uint normal_sums[];
};
layout(set = 0, binding = 11, scalar) buffer EmissionSums {
    uint emission_sums[];
};

// Adds weight · value to sum `at`.
#define ADD(sums, at, weight, value) { \
    uint high, low; \
    umulExtended(weight, value, high, low); \
    uint before = atomicAdd(sums[2u * (at)], low); \
    high += uint(before + low < before); \
    if (high != 0u) { \
        atomicAdd(sums[2u * (at) + 1u], high); \
    } \
}

struct Attributes {
    vec3 albedo;
    float alpha;
    vec3 normal;
    vec3 emission; // as a part of the greatest
};

// Texture coordinates at the middle of a part, and the level of detail at which a texel is as wide as the part.
vec3 coordinates(uint slot, AlphaVertex a, AlphaVertex b, AlphaVertex c, vec3 middle, float share, ivec2 size) {
    vec2 p = texture_coordinates(slot, a.uv0, a.uv1);
    vec2 q = texture_coordinates(slot, b.uv0, b.uv1) - p;
    vec2 r = texture_coordinates(slot, c.uv0, c.uv1) - p;
    float width = sqrt(0.5 * abs(q.x * r.y - q.y * r.x) * share) * float(max(size.x, size.y));
    return vec3(p + q * middle.y + r * middle.z, log2(max(width, 1e-9)));
}

#define SAMPLE(slot, image) sampled(image, coordinates(slot, a, b, c, middle, share, textureSize(image, 0)))

vec4 sampled(sampler2D image, vec3 place) {
    return textureLod(image, place.xy, place.z);
}

// `share`: of the triangle's area in the part.
Attributes attributes_at(Instance instance, uvec3 vertices, vec3 middle, float share) {
    AlphaVertex a = alpha_vertices[vertices.x];
    AlphaVertex b = alpha_vertices[vertices.y];
    AlphaVertex c = alpha_vertices[vertices.z];
    Attributes found;
    vec4 base = material.base_color * (a.color * middle.x + b.color * middle.y + c.color * middle.z);
    if (has_texture(TEXTURE_BASE_COLOR)) {
        base *= SAMPLE(TEXTURE_BASE_COLOR, base_color_texture);
    }
    found.albedo = base.rgb;
    found.alpha = is_opaque != 0u ? 1.0 : base.a;

    uint corners[3] = uint[](vertices.x, vertices.y, vertices.z);
    vec3 normal = vec3(0.0);
    vec3 tangent = vec3(0.0);
    for (uint i = 0u; i < scales.channels; ++i) {
        ShadingVertex vertex = shading_vertices[corners[i]];
        vec3 n = transform_normal(instance, vertex.normal);
        normal += middle[i] * n * inversesqrt(max(dot(n, n), 1e-30));
        if (has_texture(TEXTURE_NORMAL)) {
            vec3 t = transform_direction(instance, vertex.tangent.xyz);
            tangent += middle[i] * t * inversesqrt(max(dot(t, t), 1e-30));
        }
    }
    normal *= inversesqrt(max(dot(normal, normal), 1e-30));
    if (has_texture(TEXTURE_NORMAL)) {
        vec3 texel = SAMPLE(TEXTURE_NORMAL, normal_texture).xyz * 2.0 - 1.0;
        vec3 t = tangent * inversesqrt(max(dot(tangent, tangent), 1e-30));
        vec3 side = cross(normal, t) * shading_vertices[vertices.x].tangent.w * instance.handedness;
        normal = (t * texel.x + side * texel.y) * material.normal_scale + normal * texel.z;
        normal *= inversesqrt(max(dot(normal, normal), 1e-30));
    }
    found.normal = normal;

    found.emission = vec3(0.0);
    if (EMITS) {
        found.emission = material.emissive / scales.greatest_emission;
        if (has_texture(TEXTURE_EMISSIVE)) {
            found.emission *= SAMPLE(TEXTURE_EMISSIVE, emissive_texture).rgb;
        }
    }
    return found;
}

void add(uint place, float area, Attributes found) {
    uint weight = max(uint(area * scales.area_scale + 0.5), 1u);
    uint alpha = uint(round(clamp(found.alpha, 0.0, 1.0) * ALPHA_ONE));
    ADD(weight_sums, 2u * place, weight, 1u)
    uint seen = weight * alpha;
    if (seen == 0u) {
        return;
    }
    ADD(weight_sums, 2u * place + 1u, seen, 1u)
    uvec3 albedo = uvec3(round(clamp(found.albedo, 0.0, 1.0) * ONE));
    uvec3 normal = uvec3(round(clamp(found.normal, -1.0, 1.0) * NORMAL_ONE) + NORMAL_ONE);
    uvec3 emission = uvec3(round(clamp(found.emission, 0.0, 1.0) * ONE));
    for (uint i = 0u; i < scales.channels; ++i) {
        ADD(albedo_sums, 3u * place + i, seen, albedo[i])
        ADD(normal_sums, 3u * place + i, seen, normal[i])
        if (EMITS) {
            ADD(emission_sums, 3u * place + i, seen, emission[i])
        }
    }
}

void main() {
    uint pair = uint(gl_FragCoord.y) * width + uint(gl_FragCoord.x);
    if (pair >= count) {
        return;
    }
    uvec2 whose = pair_triangles[first + pair];
    uvec2 code = pair_voxels[first + pair];
    Instance instance = instances[whose.y];
    vec3 corners[3] = corners_at(instance, whose.x);
    ivec3 own = ivec3(indices[whose.x], indices[whose.x + 1u], indices[whose.x + 2u]) + instance.vertex_offset;
    float whole = 0.5 * length(triangle_of(corners).normal);
    Part part = part_in(corners[0], corners[1], corners[2], ivec3(voxel_of(code)));
    add(rank_of(code), part.share * whole, attributes_at(instance, uvec3(own), part.middle, part.share));
}
