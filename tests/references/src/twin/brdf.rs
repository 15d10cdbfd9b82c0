//! glTF's metallic-roughness BRDF: glTF 2.0, appendix B, with the Smith term correlated in height.
//!
//! With N normal, V to the viewer, L to the light, H = (L + V) / |L + V|, all of unit length:
//!
//! ```text
//! α      = max(roughness, MIN_ROUGHNESS)²
//! c_diff = (1 − metallic) · albedo
//! f0     = 0.04 · (1 − metallic) + albedo · metallic
//! F      = f0 + (1 − f0) · (1 − |V·H|)⁵                                        (B.3.4, Schlick)
//! D      = α² / (π · ((N·H)² · (α² − 1) + 1)²),  0 where N·H ≤ 0               (B.3.2, GGX)
//! V      = ½ / (N·L · √((N·V)² · (1 − α²) + α²) + |N·V| · √((N·L)² · (1 − α²) + α²))
//! f      = (1 − F) · c_diff / π + F · D · V,                 0 where N·L ≤ 0
//! ```
//!
//! V is the height-correlated Smith visibility (Heitz 2014, "Understanding the Masking-Shadowing Function in
//! Microfacet-Based BRDFs", equation 99, divided by 4 · N·L · |N·V|). The appendix writes the separable form and allows
//! others; Khronos' own viewer uses this one.
//!
//! In single precision `(N·H)² · (α² − 1) + 1` cancels where the highlight is brightest. The same value without
//! cancellation is `|N × H|² + α² · (N·H)²`; [`distribution`] documents and tests it.
//!
//! **Constant environment** of radiance L_env, arriving from everywhere. The specular reflectance under it,
//! E = f0 · A + B, is an integral without closed form; the twin, and whoever is compared with it, use the rational fit of
//! MaterialX (Academy Software Foundation, `mx_ggx_dir_albedo_analytic`), made for this very distribution and Smith term:
//! with x = |N·V| and y = α,
//!
//! ```text
//! A = clamp(p₀ / p₂, 0, 1),  B = clamp(p₁ / p₃, 0, 1)
//! pᵢ = c₀ + c₁ x + c₂ y + c₃ x y + c₄ x² + c₅ y² + c₆ x² y + c₇ x y² + c₈ x² y²      (row i of ENVIRONMENT_FIT)
//! radiance = L_env · occlusion · (c_diff · (1 − E) + E)
//! ```
//!
//! It stays within 0.06 of the integral (worst for mirrors at grazing angles). The better known fit by Karis ("Physically Based Shading on Mobile", 2014) was
//! made for another Smith term and is off by up to 0.28 for rough metals.

use std::f64::consts::PI;

use glam::DVec3;

/// Least perceptual roughness: below it single precision does not resolve the highlight of a punctual light to 1e-3.
/// The value is that of Filament ("Physically Based Rendering in Filament", section 4.8.3.3, half-float pipelines).
pub const MIN_ROUGHNESS: f64 = 0.089;

/// What the G-buffer holds of a material.
#[derive(Clone, Copy, Debug)]
pub struct Material {
    /// Base colour, linear Rec. 709.
    pub albedo: DVec3,
    /// 0 to 1.
    pub metallic: f64,
    /// Perceptual roughness, 0 to 1.
    pub roughness: f64,
}

impl Material {
    /// Colour of diffuse reflection.
    pub fn diffuse(&self) -> DVec3 {
        self.albedo * (1.0 - self.metallic)
    }

    /// Reflectance at normal incidence.
    pub fn f0(&self) -> DVec3 {
        DVec3::splat(0.04).lerp(self.albedo, self.metallic)
    }

    /// α of the GGX distribution.
    pub fn alpha(&self) -> f64 {
        self.roughness.max(MIN_ROUGHNESS).powi(2)
    }

    /// The BRDF in 1/sr. Unit vectors.
    pub fn evaluate(&self, normal: DVec3, to_viewer: DVec3, to_light: DVec3) -> DVec3 {
        let n_l = normal.dot(to_light);
        if n_l <= 0.0 {
            return DVec3::ZERO;
        }
        let half = (to_light + to_viewer).normalize();
        let fresnel = schlick(self.f0(), to_viewer.dot(half).abs());
        let specular = distribution(self.alpha(), normal.dot(half))
            * smith_visibility(self.alpha(), n_l, normal.dot(to_viewer).abs());
        (1.0 - fresnel) * self.diffuse() / PI + fresnel * specular
    }

    /// Reflected radiance under an environment of radiance 1, by the fit. `n_v` is |N·V|.
    pub fn under_environment(&self, n_v: f64) -> DVec3 {
        let specular = environment_specular(self.f0(), self.alpha(), n_v);
        self.diffuse() * (1.0 - specular) + specular
    }
}

/// Schlick's Fresnel term.
pub fn schlick(f0: DVec3, v_h: f64) -> DVec3 {
    f0 + (1.0 - f0) * (1.0 - v_h).powi(5)
}

/// GGX: normals in 1/sr about the half vector. In single precision use `α² / (π · (|N × H|² + α² · (N·H)²)²)`, which
/// is the same and does not cancel.
pub fn distribution(alpha: f64, n_h: f64) -> f64 {
    if n_h <= 0.0 {
        return 0.0;
    }
    let a2 = alpha * alpha;
    a2 / (PI * (n_h * n_h * (a2 - 1.0) + 1.0).powi(2))
}

/// Height-correlated Smith masking and shadowing, divided by 4 · N·L · N·V.
pub fn smith_visibility(alpha: f64, n_l: f64, n_v: f64) -> f64 {
    let a2 = alpha * alpha;
    let by_light = n_l * (n_v * n_v * (1.0 - a2) + a2).sqrt();
    let by_viewer = n_v * (n_l * n_l * (1.0 - a2) + a2).sqrt();
    0.5 / (by_light + by_viewer)
}

/// Coefficients of p₀ … p₃.
pub const ENVIRONMENT_FIT: [[f64; 9]; 4] = [
    [0.1003, -0.6303, 9.748, -2.038, 29.34, -8.245, -26.44, 19.99, -5.448],
    [0.9345, -2.323, 2.229, -3.748, 1.424, -0.7684, 1.436, 0.2913, 0.6286],
    [1.0, -1.765, 8.263, 11.53, 28.96, -7.507, -36.11, 15.86, 33.37],
    [1.0, 0.2281, 15.94, -55.83, 13.08, 41.26, 54.9, 300.2, -285.1],
];

/// Specular reflectance under a constant environment, by the fit.
pub fn environment_specular(f0: DVec3, alpha: f64, n_v: f64) -> DVec3 {
    let (x, y) = (n_v, alpha);
    let powers = [1.0, x, y, x * y, x * x, y * y, x * x * y, x * y * y, x * x * y * y];
    let p = ENVIRONMENT_FIT.map(|row| row.iter().zip(powers).map(|(c, power)| c * power).sum::<f64>());
    f0 * (p[0] / p[2]).clamp(0.0, 1.0) + (p[1] / p[3]).clamp(0.0, 1.0)
}
