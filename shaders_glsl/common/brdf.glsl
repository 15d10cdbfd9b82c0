// The metallic-roughness BRDF of glTF 2.0, appendix B: Lambert and GGX with Smith's height-correlated visibility
// and Schlick's Fresnel term.

const float PI = 3.14159265358979;

// Smoother than this a highlight is thinner than float arithmetic can follow (Filament, section 4.8.3.3).
const float MIN_ROUGHNESS = 0.089;

struct Reflectance {
    vec3 diffuse; // c_diff
    vec3 f0;
    float alpha; // squared perceptual roughness
};

Reflectance reflectance(vec3 albedo, float metallic, float roughness) {
    Reflectance r;
    r.diffuse = albedo * (1.0 - metallic);
    r.f0 = mix(vec3(0.04), albedo, metallic);
    float bounded = max(roughness, MIN_ROUGHNESS);
    r.alpha = bounded * bounded;
    return r;
}

// BRDF times the cosine at the surface, 1/sr.
vec3 brdf_cosine(Reflectance r, vec3 n, vec3 v, vec3 l) {
    float n_l = dot(n, l);
    if (n_l <= 0.0) {
        return vec3(0.0);
    }
    float n_v = abs(dot(n, v));
    vec3 h = normalize(v + l);
    float n_h = clamp(dot(n, h), 0.0, 1.0);
    float v_h = clamp(dot(v, h), 0.0, 1.0);

    float a2 = r.alpha * r.alpha;
    // 1 - (n·h)² by the cross product: the difference of nearly equal numbers would lose the highlight's peak.
    vec3 n_x_h = cross(n, h);
    float d_denominator = dot(n_x_h, n_x_h) + n_h * n_h * a2;
    // No microfacet that faces away, which a shading normal seen from behind asks for.
    float distribution = n_h > 0.0 ? a2 / (PI * d_denominator * d_denominator) : 0.0;
    float visibility = 0.5 / (n_l * sqrt(n_v * n_v * (1.0 - a2) + a2) + n_v * sqrt(n_l * n_l * (1.0 - a2) + a2));

    float m = 1.0 - v_h;
    float m2 = m * m;
    vec3 fresnel = r.f0 + (1.0 - r.f0) * (m2 * m2 * m);
    return ((1.0 - fresnel) * r.diffuse / PI + fresnel * (distribution * visibility)) * n_l;
}

// Share of a constant environment that the specular lobe reflects: the rational fit of MaterialX
// (`mx_ggx_dir_albedo_analytic`), made for this distribution and Smith term.
vec3 specular_albedo(Reflectance r, float n_v) {
    float x = n_v;
    float y = r.alpha;
    float x2 = x * x;
    float y2 = y * y;
    vec4 p = vec4(0.1003, 0.9345, 1.0, 1.0)
        + vec4(-0.6303, -2.323, -1.765, 0.2281) * x
        + vec4(9.748, 2.229, 8.263, 15.94) * y
        + vec4(-2.038, -3.748, 11.53, -55.83) * (x * y)
        + vec4(29.34, 1.424, 28.96, 13.08) * x2
        + vec4(-8.245, -0.7684, -7.507, 41.26) * y2
        + vec4(-26.44, 1.436, -36.11, 54.9) * (x2 * y)
        + vec4(19.99, 0.2913, 15.86, 300.2) * (x * y2)
        + vec4(-5.448, 0.6286, 33.37, -285.1) * (x2 * y2);
    vec2 scale_bias = clamp(p.xy / p.zw, 0.0, 1.0);
    return r.f0 * scale_bias.x + scale_bias.y;
}
