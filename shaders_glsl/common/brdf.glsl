// The metallic-roughness BRDF of glTF 2.0, appendix B: Lambert and GGX with Smith's height-correlated visibility
// and Schlick's Fresnel term.

const float PI = 3.14159265358979;

// Smoother than this a highlight is thinner than float arithmetic can follow.
const float MIN_ALPHA = 1e-3;

struct Reflectance {
    vec3 diffuse; // c_diff
    vec3 f0;
    float alpha; // squared perceptual roughness
};

Reflectance reflectance(vec3 albedo, float metallic, float roughness) {
    Reflectance r;
    r.diffuse = albedo * (1.0 - metallic);
    r.f0 = mix(vec3(0.04), albedo, metallic);
    r.alpha = max(roughness * roughness, MIN_ALPHA);
    return r;
}

// BRDF times the cosine at the surface, 1/sr.
vec3 brdf_cosine(Reflectance r, vec3 n, vec3 v, vec3 l) {
    float n_l = dot(n, l);
    if (n_l <= 0.0) {
        return vec3(0.0);
    }
    float n_v = max(dot(n, v), 1e-4);
    vec3 h = normalize(v + l);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float v_h = clamp(dot(v, h), 0.0, 1.0);

    float a2 = r.alpha * r.alpha;
    // 1 - (n·h)² by the cross product: the difference of nearly equal numbers would lose the highlight's peak.
    vec3 n_x_h = cross(n, h);
    float d_denominator = dot(n_x_h, n_x_h) + n_h * n_h * a2;
    float distribution = a2 / (PI * d_denominator * d_denominator);
    float visibility = 0.5 / (n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2));

    float m = 1.0 - v_h;
    float m2 = m * m;
    vec3 fresnel = r.f0 + (1.0 - r.f0) * (m2 * m2 * m);
    return ((1.0 - fresnel) * r.diffuse / PI + fresnel * (distribution * visibility)) * n_l;
}

// Share of a constant environment that the specular lobe reflects: Karis's fit ("Physically based shading on
// mobile", 2014) of the split-sum integral.
vec3 specular_albedo(vec3 f0, float roughness, float n_v) {
    const vec4 c0 = vec4(-1.0, -0.0275, -0.572, 0.022);
    const vec4 c1 = vec4(1.0, 0.0425, 1.04, -0.04);
    vec4 r = roughness * c0 + c1;
    float a = min(r.x * r.x, exp2(-9.28 * n_v)) * r.x + r.y;
    vec2 scale_bias = vec2(-1.04, 1.04) * a + r.zw;
    return f0 * scale_bias.x + scale_bias.y;
}
