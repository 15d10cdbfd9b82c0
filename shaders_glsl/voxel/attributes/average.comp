#version 460
#extension GL_EXT_scalar_block_layout : require
#define TOTAL_ACCESS readonly
#include "voxel/attributes/sums.glsl"

// From sums to averages.

layout(local_size_x = 64) in;

#include "voxel/attributes/total.glsl"
layout(set = 0, binding = 8, scalar) readonly buffer WeightSums {
    uint weight_sums[];
};
layout(set = 0, binding = 9, scalar) readonly buffer AlbedoSums {
    uint albedo_sums[];
};
layout(set = 0, binding = 10, scalar) readonly buffer NormalSums {
    uint normal_sums[];
};
layout(set = 0, binding = 11, scalar) readonly buffer EmissionSums {
    uint emission_sums[];
};
layout(set = 0, binding = 16, scalar) writeonly buffer Albedo {
    vec4 albedo[]; // linear; opacity
};
layout(set = 0, binding = 17, scalar) writeonly buffer Normals {
    vec4 normals[]; // world space; area in voxel sides squared
};
layout(set = 0, binding = 18, scalar) writeonly buffer Emission {
    vec4 emission[]; // cd/m²; 0
};

#define SUM(sums, at) (float(sums[2u * (at) + 1u]) * 4294967296.0 + float(sums[2u * (at)]))

void main() {
    uint voxel = gl_GlobalInvocationID.y * gl_NumWorkGroups.x * gl_WorkGroupSize.x + gl_GlobalInvocationID.x;
    if (voxel >= total) {
        return;
    }
    float weight = SUM(weight_sums, 2u * voxel);
    float seen = SUM(weight_sums, 2u * voxel + 1u);
    vec3 colors = vec3(0.0);
    vec3 normal = vec3(0.0);
    vec3 emitted = vec3(0.0);
    if (seen > 0.0) {
        for (uint i = 0u; i < 3u; ++i) {
            colors[i] = SUM(albedo_sums, 3u * voxel + i) / seen;
            normal[i] = SUM(normal_sums, 3u * voxel + i) / seen;
            emitted[i] = SUM(emission_sums, 3u * voxel + i) / seen;
        }
        normal = (normal - NORMAL_ONE) / NORMAL_ONE;
    }
    albedo[voxel] = vec4(colors / ONE, weight > 0.0 ? seen / (ALPHA_ONE * weight) : 0.0);
    normals[voxel] = vec4(normal, weight / scales.area_scale);
    emission[voxel] = vec4(emitted / ONE * scales.greatest_emission, 0.0);
}
