#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/voxel_row.glsl"
#include "common/pulled_vertices.glsl"
#include "common/materials.glsl"
#include "voxel/attributes/sums.glsl"
#include "voxel/attributes/clip.glsl"

// Adds what a triangle is like to the sums of each voxel that it touches, by the area of its part there.

layout(location = 3) flat in uvec4 vertices; // of the triangle; its instance

layout(push_constant, scalar) uniform AttributesPush {
    uint is_opaque; // alpha does not count
};
layout(set = 0, binding = 2, scalar) readonly buffer Bits {
    uint bits[];
};
layout(set = 0, binding = 7, scalar) readonly buffer Firsts {
    uint firsts[];
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
Attributes attributes_at(vec3 middle, float share) {
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

    Instance instance = instances[vertices.w];
    uint corners[3] = uint[](vertices.x, vertices.y, vertices.z);
    vec3 normal = vec3(0.0);
    vec3 tangent = vec3(0.0);
    for (int i = 0; i < 3; ++i) {
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
    if (scales.greatest_emission > 0.0) {
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
    for (uint i = 0u; i < 3u; ++i) {
        ADD(albedo_sums, 3u * place + i, seen, albedo[i])
        ADD(normal_sums, 3u * place + i, seen, normal[i])
        if (emission[i] != 0u) {
            ADD(emission_sums, 3u * place + i, seen, emission[i])
        }
    }
}

void main() {
    Row row = fragment_row();
    float whole = 0.5 * length(row.triangle.normal);
    for (int k = row.part.x; k <= row.part.y; ++k) {
        ivec3 voxel = row.voxel;
        voxel[row.axis] = k;
        uint word = word_index(uvec2(voxel.xy), uint(voxel.z) / 32u);
        uint bit = 1u << (uint(voxel.z) % 32u);
        uint set = bits[word];
        if ((set & bit) != 0u && makes_up(row.triangle, voxel)) {
            Part part = part_in(corner_a, corner_b, corner_c, voxel);
            float share = whole > 0.0 ? min(part.area / whole, 1.0) : 0.0;
            uint place = firsts[word] + bitCount(set & (bit - 1u));
            add(place, part.area, attributes_at(part.middle, share));
        }
    }
}
