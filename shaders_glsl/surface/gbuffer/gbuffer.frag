#version 460
#extension GL_EXT_scalar_block_layout : require
#include "common/views.glsl"
#include "common/normals.glsl"
#include "common/surface_fragment.glsl"

layout(location = 0) out vec4 albedo; // a: ambient occlusion
layout(location = 1) out vec4 normal;
layout(location = 2) out vec4 roughness_metallic; // roughness, metallic, unlit
layout(location = 3) out vec4 emissive;
layout(location = 4) out uvec4 ids; // object, primitive, material, each from 1; normal of the triangle

// Normal of the triangle itself, on the viewer's side.
vec3 face_normal() {
    vec3 n = cross(dFdx(vertex_position), dFdy(vertex_position));
    n *= inversesqrt(max(dot(n, n), 1e-38));
    return dot(n, direction_to_eye(0u, vertex_position)) >= 0.0 ? n : -n;
}

void main() {
    Surface surface = fragment_surface();
    albedo = vec4(surface.albedo, surface.occlusion);
    normal = vec4(surface.normal, 0.0);
    roughness_metallic = vec4(surface.roughness, surface.metallic, surface.unlit ? 1.0 : 0.0, 0.0);
    emissive = vec4(surface.emissive, 0.0);
    uint primitive = vertex_ids.y + uint(gl_PrimitiveID) + 1u;
    ids = uvec4(vertex_ids.x, primitive, vertex_ids.z + 1u, pack_normal(face_normal()));
}
