//! Shadows by rays.
//!
//! A point of a surface is lit where the segment from it, moved by `offset` along its flat normal, to the light meets
//! no `OPAQUE` or `MASK` surface, from either side. A surface that faces away from the light (flat normal · direction
//! to the light ≤ 0) is not lit.
//!
//! A shadow map answers for texels, so it may differ near a shadow's edge. *Near* is: moving the point by one or two
//! texels, in eight directions, changes the answer. Points are moved across the light's rays, then along them onto
//! the receiver's plane, as a texel of the map lies on it; where the plane is seen by the light at a grazing angle,
//! along the rays by at most [`MOST_SLOPE`] times the way across.

use glam::DVec3;
use shadowgraph::scene::{Light, LightKind};

use super::scene::{Footprint, Line, Ray, Rule, Scene};
use crate::parallel;

/// Greatest slope of a receiver, against a plane across the light's rays.
pub const MOST_SLOPE: f64 = 20.0;

/// Distances in texels at which the points of the ring lie.
pub const RING: [f64; 2] = [1.0, 2.0];

/// A point that may be lit.
#[derive(Clone, Copy, Debug)]
pub struct Receiver {
    /// World space.
    pub position: DVec3,
    /// Unit normal of the triangle, towards the viewer.
    pub normal: DVec3,
    /// Width of a shadow-map texel here, across the light's rays, metres.
    pub texel: f64,
}

/// What a light sees of a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Visibility {
    /// The light is seen.
    pub lit: bool,
    /// A shadow's edge is within two texels.
    pub near_edge: bool,
    /// The surface faces the light, and is within its range and cone: elsewhere its shadow shows nowhere.
    pub reached: bool,
}

/// Unit vector to a light, and the distance to it.
pub fn toward_light(light: &Light, position: DVec3) -> (DVec3, f64) {
    match light.kind {
        LightKind::Directional { direction, .. } => (-direction.as_dvec3().normalize(), f64::INFINITY),
        LightKind::Point { position: from, .. } | LightKind::Spot { position: from, .. } => {
            let way = from.as_dvec3() - position;
            (way.normalize_or_zero(), way.length())
        }
    }
}

/// Width of a shadow-map texel at a distance from a spot light: the map spans `2 · outer` over `resolution` texels.
pub fn spot_texel(outer: f64, resolution: u32, along_axis: f64) -> f64 {
    2.0 * outer.tan() * along_axis / f64::from(resolution)
}

/// Whether a light is seen from a receiver.
pub fn lit(scene: &Scene, light: &Light, receiver: &Receiver, offset: f64) -> bool {
    let (to_light, distance) = toward_light(light, receiver.position);
    if receiver.normal.dot(to_light) <= 0.0 {
        return false;
    }
    let origin = receiver.position + receiver.normal * offset;
    let (direction, far) = if distance.is_finite() { toward_light(light, origin) } else { (to_light, distance) };
    let footprint = Footprint::Width(receiver.texel);
    !scene.any(&Ray { line: Line { origin, direction }, near: 0.0, far, footprint }, Rule::SHADOW)
}

/// What a light sees of a receiver.
pub fn visibility(scene: &Scene, light: &Light, receiver: &Receiver, offset: f64) -> Visibility {
    let (to_light, distance) = toward_light(light, receiver.position);
    let facing = receiver.normal.dot(to_light);
    let reached = facing > 0.0
        && match light.kind {
            LightKind::Directional { .. } => true,
            LightKind::Point { range, .. } => distance < f64::from(range),
            LightKind::Spot { direction, range, outer, .. } => {
                distance < f64::from(range) && -direction.as_dvec3().normalize().dot(to_light) > f64::from(outer).cos()
            }
        };
    let here = lit(scene, light, receiver, offset);
    let (across, up) = to_light.any_orthonormal_pair();
    let slope = 1.0 / facing.max(1.0 / MOST_SLOPE);
    let near_edge = facing > 0.0
        && RING.iter().any(|radius| {
            (0..8).any(|k| {
                let (sin, cos) = (f64::from(k) * std::f64::consts::FRAC_PI_4).sin_cos();
                let side = (across * cos + up * sin) * (radius * receiver.texel);
                let position = receiver.position + side - to_light * (side.dot(receiver.normal) * slope);
                lit(scene, light, &Receiver { position, ..*receiver }, offset) != here
            })
        });
    Visibility { lit: here, near_edge, reached }
}

/// [`visibility`] of the receivers of a picture, `None` where there is no surface.
pub fn cast(
    scene: &Scene,
    light: &Light,
    receivers: &[Option<Receiver>],
    width: u32,
    offset: f64,
) -> Vec<Option<Visibility>> {
    let width = width as usize;
    parallel::rows(receivers.len() / width, |y| {
        let row = &receivers[y * width..(y + 1) * width];
        row.iter().map(|r| r.as_ref().map(|r| visibility(scene, light, r, offset))).collect()
    })
}
