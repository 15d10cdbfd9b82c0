// Light that comes from everywhere alike.
layout(set = 0, binding = 12, scalar) uniform Environment {
    vec3 radiance; // cd/m²
} environment;

// Reflected towards the viewer: diffuse plus split-sum specular, both under ambient occlusion.
vec3 environment_reflection(Reflectance r, float occlusion, float n_v) {
    vec3 specular = specular_albedo(r, n_v);
    return environment.radiance * occlusion * (r.diffuse * (1.0 - specular) + specular);
}
