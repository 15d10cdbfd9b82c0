//! Radiance of a surface under punctual lights and a constant environment.
//!
//! ```text
//! radiance = emissive + Σ visibility · f(V, L) · E + L_env · occlusion · (c_diff · (1 − E_spec) + E_spec)
//! ```
//!
//! with the BRDF f and the environment term of [`super::brdf`], and the irradiance E = N·L · colour · … of
//! `KHR_lights_punctual`: `illuminance` for directional lights; `intensity · window / d²` for point and spot lights,
//! with `window = max(min(1 − (d / range)⁴, 1), 0)`; times, for spot lights, `clamp(cos θ · s + o, 0, 1)²` with
//! `s = 1 / max(0.001, cos inner − cos outer)`, `o = −cos outer · s` and θ the angle between the axis and −L.
//! Photometric units are kept: lux in, cd/m² out. Occlusion darkens the environment only.

use glam::DVec3;
use shadowgraph::scene::{Light, LightKind};

use super::brdf::Material;
use super::shadow::toward_light;

/// What the G-buffer holds of a point.
#[derive(Clone, Copy, Debug)]
pub struct Sample {
    /// World space.
    pub position: DVec3,
    /// Shading normal, world space, unit length.
    pub normal: DVec3,
    /// For the BRDF.
    pub material: Material,
    /// cd/m².
    pub emissive: DVec3,
    /// 0 (dark) to 1.
    pub occlusion: f64,
}

/// Irradiance on a plane that faces a light, and the unit vector to it.
pub fn facing_irradiance(light: &Light, position: DVec3) -> (DVec3, DVec3) {
    let (to_light, distance) = toward_light(light, position);
    let fall_off = |range: f32| {
        let window = (1.0 - (distance / f64::from(range)).powi(4)).clamp(0.0, 1.0);
        window / (distance * distance)
    };
    let strength = match light.kind {
        LightKind::Directional { illuminance, .. } => f64::from(illuminance),
        LightKind::Point { intensity, range, .. } => f64::from(intensity) * fall_off(range),
        LightKind::Spot { direction, intensity, range, inner, outer, .. } => {
            let (cos_inner, cos_outer) = (f64::from(inner).cos(), f64::from(outer).cos());
            let scale = 1.0 / (cos_inner - cos_outer).max(0.001);
            let cos_angle = -direction.as_dvec3().normalize().dot(to_light);
            let cone = ((cos_angle - cos_outer) * scale).clamp(0.0, 1.0).powi(2);
            f64::from(intensity) * fall_off(range) * cone
        }
    };
    (light.color.as_dvec3() * strength, to_light)
}

/// Radiance towards the viewer that one light, fully visible, causes.
pub fn direct(sample: &Sample, to_viewer: DVec3, light: &Light) -> DVec3 {
    let (irradiance, to_light) = facing_irradiance(light, sample.position);
    irradiance * sample.normal.dot(to_light).max(0.0) * sample.material.evaluate(sample.normal, to_viewer, to_light)
}

/// Radiance towards the viewer. `lights` come with their visibility, 0 to 1.
pub fn radiance<'a>(
    sample: &Sample,
    to_viewer: DVec3,
    lights: impl IntoIterator<Item = (&'a Light, f64)>,
    environment: DVec3,
) -> DVec3 {
    let direct: DVec3 = lights.into_iter().map(|(light, seen)| direct(sample, to_viewer, light) * seen).sum();
    let n_v = sample.normal.dot(to_viewer).abs().min(1.0);
    sample.emissive + direct + environment * sample.occlusion * sample.material.under_environment(n_v)
}
