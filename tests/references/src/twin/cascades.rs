//! Cascades of a directional light: where a view is split, what part of the world each map covers, and which map a
//! point reads.
//!
//! - Splits: Zhang, Sun, Xu, Lun 2006, "Parallel-Split Shadow Maps for Large-scale Virtual Environments", section 4:
//!   uniform, logarithmic, and the blend of both by λ.
//! - Fit: stabilised after Valient ("Stable Rendering of Cascaded Shadow Maps", ShaderX6, 2008). A map covers the
//!   least sphere around the slice of the view, so that its size does not change as the camera turns; the radius is
//!   rounded up to 1/16 m, and the map's origin is snapped to whole texels of a grid fixed in the world, so that
//!   texels do not move against it. A margin of one texel a side, of which snapping takes half at most.
//! - Light space: z towards the light, x = up × z with a constant up (y, or z where the light is vertical),
//!   y = z × x.

use glam::{DMat3, DVec2, DVec3};
use shadowgraph::scene::View;

use super::camera::Camera;

/// Distances from the eye of `count` slices of `near..far`: `count + 1` values. `lambda` is 0 for uniform splits, 1
/// for logarithmic ones.
pub fn splits(near: f64, far: f64, count: usize, lambda: f64) -> Vec<f64> {
    let split = |i: usize| {
        let t = i as f64 / count as f64;
        lambda * near * (far / near).powf(t) + (1.0 - lambda) * (near + (far - near) * t)
    };
    (0..=count).map(split).collect()
}

/// Cascade of a distance along the view axis, and the share of the next one: 0 up to where the last `overlap` (0 to 1)
/// of the slice begins, then rising to 1 at its end. `None` beyond the last split.
pub fn select(splits: &[f64], z: f64, overlap: f64) -> Option<(usize, f64)> {
    let index = splits.windows(2).position(|s| z <= s[1])?;
    let (start, end) = (splits[index], splits[index + 1]);
    let band = (end - start) * overlap;
    let last = index + 2 == splits.len();
    let share = if last || band <= 0.0 { 0.0 } else { ((z - (end - band)) / band).clamp(0.0, 1.0) };
    Some((index, share))
}

/// A sphere in view space whose centre lies on the view axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sphere {
    /// Distance of the centre along the view axis.
    pub distance: f64,
    /// Metres.
    pub radius: f64,
}

/// The least sphere around a slice of a symmetric view. `corner` gives the distance from the axis of a corner of the
/// slice at a distance from the eye, and is linear in it.
pub fn slice_sphere(near: f64, far: f64, corner: impl Fn(f64) -> f64) -> Sphere {
    let (at_near, at_far) = (corner(near), corner(far));
    // Equally far from near and far corners; not beyond the far plane, where the far corners alone count.
    let middle = (far * far - near * near + at_far * at_far - at_near * at_near) / (2.0 * (far - near));
    let distance = middle.min(far);
    Sphere { distance, radius: at_far.hypot(far - distance) }
}

/// What a cascade's map covers.
#[derive(Clone, Copy, Debug)]
pub struct Fit {
    /// World from light space, a rotation.
    pub world_from_light: DMat3,
    /// Least corner in light space x and y, a whole number of texels.
    pub min: DVec2,
    /// Width of a texel, metres.
    pub texel: f64,
    /// Texels a side.
    pub resolution: u32,
}

/// Light space of a direction in which light travels.
pub fn light_space(direction: DVec3) -> DMat3 {
    let z = -direction.normalize();
    let up = if z.y.abs() < 0.999 { DVec3::Y } else { DVec3::Z };
    let x = up.cross(z).normalize();
    DMat3::from_cols(x, z.cross(x), z)
}

/// The stabilised fit of the slice `near..far` of a view.
pub fn fit(view: &View, near: f64, far: f64, direction: DVec3, resolution: u32) -> Fit {
    // 1. The sphere around the slice
    let camera = Camera::new(view);
    let axis = camera.line(f64::from(view.size[0]) * 0.5, f64::from(view.size[1]) * 0.5);
    let corner = camera.line(0.0, 0.0);
    let sphere = slice_sphere(near, far, |z| corner.at(z).distance(axis.at(z)));

    // 2. A size that does not change as the camera moves
    let radius = (sphere.radius * 16.0).ceil() / 16.0;
    let texel = 2.0 * radius / f64::from(resolution - 2);

    // 3. An origin on the grid
    let world_from_light = light_space(direction);
    let center = (world_from_light.transpose() * axis.at(sphere.distance)).truncate();
    let min = ((center - radius) / texel).round() - 1.0;
    Fit { world_from_light, min: min * texel, texel, resolution }
}

impl Fit {
    /// Texel coordinates of a point in world space: 0 to `resolution` within the map.
    pub fn texels(&self, position: DVec3) -> DVec2 {
        ((self.world_from_light.transpose() * position).truncate() - self.min) / self.texel
    }

    /// Whether the map covers a point in world space.
    pub fn covers(&self, position: DVec3) -> bool {
        let p = self.texels(position);
        p.cmpge(DVec2::ZERO).all() && p.cmple(DVec2::splat(f64::from(self.resolution))).all()
    }
}
