//! What comes through blended surfaces to a point, by rays.
//!
//! On the segment from the point, moved by `offset` along its flat normal to the light's side, every blended surface
//! multiplies light by what it lets through, channel by channel, from either side:
//!
//! - α over what lies behind: 1 − α; with a transmission t (`KHR_materials_transmission`): 1 − α (1 − p), where
//!   p = t · base · (1 − metallic) · (1 − F), and F = 0.04 + 0.96 (1 − |n · l|)⁵ (Schlick, of a dielectric); unlit
//!   materials: p = t · base.
//! - What only adds lets all through.

use std::ops::ControlFlow;

use glam::DVec3;
use shadowgraph::scene::{AlphaMode, Light, Scene as Source};

use super::scene::{Footprint, Line, Ray, Rule, Scene};
use super::shadow::{MOST_SLOPE, RING, Receiver, toward_light};
use crate::parallel;

/// The blended surfaces of a scene alone; materials keep their places.
pub fn casters(source: &Source) -> Source {
    let mut casters = source.clone();
    for mesh in &mut casters.meshes {
        mesh.primitives.retain(|primitive| source.materials[primitive.material].is_blended());
    }
    casters
}

/// What comes through to a point.
#[derive(Clone, Copy, Debug)]
pub struct Transmitted {
    /// Channel by channel.
    pub through: DVec3,
    /// Within two texels it changes by more than was asked.
    pub near_edge: bool,
    /// The surface faces the light.
    pub reached: bool,
}

/// What comes through of a light to a receiver. `casters`: of [`casters`], seeing what is blended.
pub fn through(casters: &Scene, light: &Light, receiver: &Receiver, offset: f64) -> DVec3 {
    let (to_light, distance) = toward_light(light, receiver.position);
    let side = receiver.normal.dot(to_light).signum();
    let origin = receiver.position + receiver.normal * side * offset;
    let (direction, far) = if distance.is_finite() { toward_light(light, origin) } else { (to_light, distance) };
    let ray = Ray { line: Line { origin, direction }, near: 0.0, far, footprint: Footprint::Width(receiver.texel) };
    let mut product = DVec3::ONE;
    casters.each(&ray, Rule::SHADOW, |hit, _| {
        let surface = casters.surface(&ray, &hit);
        let material = &casters.source.materials[surface.ids[2] as usize - 1];
        let fresnel = 0.04 + 0.96 * (1.0 - surface.normal.dot(direction).abs().min(1.0)).powi(5);
        let enters = if material.unlit { 1.0 } else { (1.0 - surface.metallic) * (1.0 - fresnel) };
        let passing = surface.base_color.truncate() * surface.transmission * enters;
        let alpha = match material.alpha_mode {
            AlphaMode::Add => return ControlFlow::Continue(()),
            AlphaMode::Opaque => 1.0,
            _ => surface.base_color.w,
        };
        product *= DVec3::ONE - alpha * (DVec3::ONE - passing);
        ControlFlow::Continue(())
    });
    product
}

/// [`through`] of the receivers of a picture, `None` where there is no surface. `change`: how much is an edge.
pub fn cast(
    casters: &Scene,
    light: &Light,
    receivers: &[Option<Receiver>],
    width: u32,
    offset: f64,
    change: f64,
) -> Vec<Option<Transmitted>> {
    let of = |receiver: &Receiver| {
        let here = through(casters, light, receiver, offset);
        let (to_light, _) = toward_light(light, receiver.position);
        let facing = receiver.normal.dot(to_light);
        let (across, up) = to_light.any_orthonormal_pair();
        let slope = 1.0 / facing.max(1.0 / MOST_SLOPE);
        let near_edge = RING.iter().any(|radius| {
            (0..8).any(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
                let side = (across * cos + up * sin) * (radius * receiver.texel);
                let position = receiver.position + side - to_light * (side.dot(receiver.normal) * slope);
                let there = through(casters, light, &Receiver { position, ..*receiver }, offset);
                (there - here).abs().max_element() > change
            })
        });
        Transmitted { through: here, near_edge, reached: facing > 0.0 }
    };
    let width = width as usize;
    parallel::rows(receivers.len() / width, |y| {
        receivers[y * width..(y + 1) * width].iter().map(|receiver| receiver.as_ref().map(of)).collect()
    })
}
